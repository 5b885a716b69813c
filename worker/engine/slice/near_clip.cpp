#include "worker/engine/slice/near_clip.h"

#include <algorithm>

namespace shutterline::engine {
namespace {

template <typename Inside>
ClippedPolygon Clip(const ClippedPolygon& polygon, const Inside& inside, bool at_near) {
  ClippedPolygon clipped;
  for (int i = 0; i < polygon.count; ++i) {
    const LineCorner& a = polygon.corners[size_t(i)];
    const LineCorner& b = polygon.corners[size_t((i + 1) % polygon.count)];
    const double at_a = inside(a);
    const double at_b = inside(b);
    if (at_a >= 0) clipped.corners[size_t(clipped.count++)] = a;
    if ((at_a >= 0) == (at_b >= 0)) continue;
    const LineCorner& in = at_a >= 0 ? a : b;
    const LineCorner& out = at_a >= 0 ? b : a;
    const double in_distance = at_a >= 0 ? at_a : at_b;
    const double out_distance = at_a >= 0 ? at_b : at_a;
    const double total = in_distance - out_distance;
    LineCorner& corner = clipped.corners[size_t(clipped.count++)];
    for (size_t c = 0; c < 4; ++c) {
      corner[c] = (in_distance / total) * out[c] + (-out_distance / total) * in[c];
    }
    // On the near plane w = z: said so, because w may have cancelled where z has not.
    if (at_near) corner[3] = std::max(corner[3], corner[2]);
  }
  return clipped;
}

}  // namespace

ClippedPolygon ClipTriangle(const std::array<LineCorner, 3>& corners, double far_depth) {
  ClippedPolygon polygon{.count = 3};
  std::copy(corners.begin(), corners.end(), polygon.corners.begin());
  polygon = Clip(
      polygon, [](const LineCorner& c) { return c[3] - c[2]; }, true);
  if (polygon.count < 3) return polygon;
  return Clip(
      polygon, [far_depth](const LineCorner& c) { return c[2] - far_depth * c[3]; }, false);
}

}  // namespace shutterline::engine
