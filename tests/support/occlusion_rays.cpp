#include "tests/support/occlusion_rays.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "common/base/status_macros.h"
#include "worker/engine/occlusion/receiver.h"
#include "worker/engine/sampling/point_pattern.h"

namespace shutterline::engine {
namespace {

/// Of a point's largest coordinate: rays start so far above their surface, some thirty roundings of the
/// single-precision coordinates that they are traced in. Much more would miss what is fine.
constexpr double kLift = 4e-6;

}  // namespace

absl::StatusOr<OcclusionRays> OcclusionRays::Create(std::shared_ptr<const FrameScene> frame,
                                                    const OcclusionSettings& settings, int threads) {
  if (settings.motion) {
    SL_ASSIGN_OR_RETURN(EmbreeFrame embree, EmbreeFrame::Build(*frame, threads));
    return OcclusionRays(std::move(frame), settings, std::move(embree));
  }
  SL_ASSIGN_OR_RETURN(const EmbreeDevice device, MakeEmbreeDevice());
  SL_ASSIGN_OR_RETURN(EmbreeFrame embree, EmbreeFrame::BuildAt(*frame, 0.5, false, device));
  return OcclusionRays(std::move(frame), settings, std::move(embree));
}

double OcclusionRays::At(uint32_t triangle, double b1, double b2, int rays, uint64_t seed) const {
  const double scale = embree_.scale();
  const auto receiver = Receiver::Create(*frame_, triangle, b1, b2, scale);
  if (!receiver) return 1;
  const PixelPoints points({seed, seed * 0x9e3779b97f4a7c15u + 1, seed * 0xd1342543de82ef95u + 2});
  const bool moves = settings_.motion && !receiver->IsStill();
  ReceiverFrame frame = receiver->At(0.5);
  double far = std::numeric_limits<double>::infinity();
  if (settings_.radius) far = *settings_.radius / scale;
  int open = 0;
  for (int i = 0; i < rays; ++i) {
    const PixelPoint p = points.At(uint32_t(i));
    const double t = settings_.motion ? p.t : 0.5;
    if (moves) frame = receiver->At(t);
    const double r = std::sqrt(p.x), turn = 2 * std::numbers::pi * p.y;
    const V3d direction =
        r * std::cos(turn) * frame.x + r * std::sin(turn) * frame.y + std::sqrt(1 - p.x) * frame.pole;
    if (direction.dot(frame.face) <= 0) {
      ++open;
      continue;
    }
    const double lift = kLift * std::max({std::abs(frame.position.x), std::abs(frame.position.y),
                                          std::abs(frame.position.z)});
    const V3d start = frame.position + lift * frame.face;
    double reach = far;
    const double share = std::fmod((i + 0.5) * 0.7548776662466927, 1.0);
    if (settings_.falloff == OcclusionFalloff::kLinear) reach *= share;
    if (settings_.falloff == OcclusionFalloff::kQuadratic) reach *= std::sqrt(share);
    RTCRay ray{};
    ray.org_x = float(start.x);
    ray.org_y = float(start.y);
    ray.org_z = float(start.z);
    ray.dir_x = float(direction.x);
    ray.dir_y = float(direction.y);
    ray.dir_z = float(direction.z);
    ray.tfar = float(reach);
    ray.time = float(t);
    ray.mask = ~0u;
    open += !IsOccluded(embree_.scene(), ray);
  }
  return double(open) / rays;
}

}  // namespace shutterline::engine
