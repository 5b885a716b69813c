#include "worker/engine/shading/shadows.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "common/base/status_macros.h"

namespace shutterline::engine {
namespace {

/// Of a point's largest coordinate: rays start so far above their surface, some hundred roundings of the
/// single-precision coordinates that they are traced in.
constexpr double kLift = 2e-5;

}  // namespace

absl::StatusOr<std::shared_ptr<const Shadows>> Shadows::Build(const FrameScene& frame) {
  SL_ASSIGN_OR_RETURN(const EmbreeDevice device, MakeEmbreeDevice());
  SL_ASSIGN_OR_RETURN(EmbreeFrame embree, EmbreeFrame::BuildAt(frame, 0.5, false, device));
  return std::shared_ptr<const Shadows>(new Shadows(std::move(embree)));
}

bool Shadows::IsShadowed(const V3d& position, const V3d& face, const V3d& to_light, double distance) const {
  const double scale = embree_.scale();
  const V3d origin = position / scale;
  const double lift = kLift * std::max({std::abs(origin.x), std::abs(origin.y), std::abs(origin.z)});
  const V3d start = origin + lift * face;
  RTCRay ray{};
  ray.org_x = float(start.x);
  ray.org_y = float(start.y);
  ray.org_z = float(start.z);
  ray.dir_x = float(to_light.x);
  ray.dir_y = float(to_light.y);
  ray.dir_z = float(to_light.z);
  ray.tnear = 0;
  ray.tfar = float(std::max(distance / scale - lift, 0.0));
  ray.mask = ~0u;
  return IsOccluded(embree_.scene(), ray);
}

}  // namespace shutterline::engine
