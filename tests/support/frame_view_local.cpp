// The camera's map, until the scene module brings its own: weak, so that that one wins.
#include "worker/engine/scene/frame_scene.h"

namespace shutterline::engine {

__attribute__((weak)) RasterPoint FrameView::RasterFromView(const V3d& p) const {
  const double w = perspective ? -p.z : 1;
  const double z = perspective ? znear : (zfar + p.z) / (zfar - znear);
  return {scale_x * p.x + center_x * w, -scale_y * p.y + center_y * w, z, w};
}

__attribute__((weak)) V3d FrameView::ViewFromRaster(const RasterPoint& p) const {
  return {(p.x - center_x * p.w) / scale_x, (center_y * p.w - p.y) / scale_y,
          perspective ? -p.w : p.z * (zfar - znear) - zfar};
}

__attribute__((weak)) double FrameView::FarDepth() const {
  return perspective && zfar > 0 ? znear / zfar : 0;
}

}  // namespace shutterline::engine
