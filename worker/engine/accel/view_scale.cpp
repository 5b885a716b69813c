#include "worker/engine/accel/view_scale.h"

#include <algorithm>
#include <cmath>

namespace shutterline::engine {

double ViewScale(const FrameScene& frame) {
  double largest = 0;
  for (const FrameTriangle& triangle : frame.triangles) {
    const FramePrimitive& primitive = frame.primitives[triangle.primitive];
    for (const uint32_t vertex : triangle.vertices) {
      for (int i = 0; i < primitive.PointsPerVertex(); ++i) {
        const V3d p = frame.view.ViewFromRaster(frame.ControlPoint(primitive, vertex, i));
        largest = std::max({largest, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
      }
    }
  }
  if (!(largest > 0) || !std::isfinite(largest)) return 1;
  return std::ldexp(1.0, std::ilogb(largest) - kViewScaleExponent);
}

}  // namespace shutterline::engine
