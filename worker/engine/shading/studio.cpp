#include "worker/engine/shading/studio.h"

#include <algorithm>
#include <cmath>

#include "common/math/unit_vector.h"

namespace shutterline::engine {
namespace {

/// A rectangle of light, seen from the middle of the room, with soft borders.
struct SoftBox {
  V3d axis, right, up;             ///< Unit: towards its middle, and along its sides.
  double half_width, half_height;  ///< Tangents of the angles that it spans.
  V3d radiance;

  SoftBox(const V3d& towards, double width, double height, const V3d& light)
      : axis(UnitOrZero(towards)),
        right(UnitOrZero(V3d(0, 1, 0).cross(axis))),
        up(axis.cross(right)),
        half_width(width),
        half_height(height),
        radiance(light) {}
};

const SoftBox kBoxes[] = {
    {V3d(-0.7, 0.75, 0.8), 0.55, 0.4, V3d(7.0, 6.8, 6.5)},
    {V3d(1.0, 0.35, 0.45), 0.35, 0.7, V3d(1.6, 1.7, 1.85)},
    {V3d(0.35, 0.5, -1.0), 0.8, 0.25, V3d(3.0, 3.0, 3.1)},
};

double SmoothStep(double from, double to, double x) {
  const double t = std::clamp((x - from) / (to - from), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

double ShareOf(const SoftBox& box, const V3d& direction) {
  const double along = direction.dot(box.axis);
  if (along <= 0.05) return 0;
  constexpr double kSoft = 0.12;
  const double x = std::abs(direction.dot(box.right) / along);
  const double y = std::abs(direction.dot(box.up) / along);
  return (1 - SmoothStep(box.half_width - kSoft, box.half_width + kSoft, x)) *
         (1 - SmoothStep(box.half_height - kSoft, box.half_height + kSoft, y));
}

}  // namespace

V3d StudioRadiance(const V3d& direction) {
  // Floor, wall and ceiling.
  const double up = SmoothStep(-0.25, 0.9, direction.y);
  const double floor = SmoothStep(0.0, -0.6, direction.y);
  V3d sum = V3d(0.32, 0.33, 0.35) + up * V3d(0.5, 0.52, 0.56) - floor * V3d(0.2, 0.2, 0.21);
  for (const SoftBox& box : kBoxes) sum += ShareOf(box, direction) * box.radiance;
  constexpr double kExposure = 0.55;
  return kExposure * sum;
}

std::shared_ptr<const SkyMap> Studio() {
  constexpr int kWidth = 256;
  static const std::shared_ptr<const SkyMap> studio = SkyMap::Make(StudioRadiance, kWidth);
  return studio;
}

}  // namespace shutterline::engine
