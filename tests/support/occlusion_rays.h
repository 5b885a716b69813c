#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <memory>

#include "common/job/occlusion_settings.h"
#include "worker/engine/accel/embree_frame.h"
#include "worker/engine/scene/frame_scene.h"

namespace shutterline::engine {

/// Ambient occlusion by rays, of the same hemispheres and rules as AmbientOcclusion: to judge it. Immutable;
/// any number of threads may ask.
class OcclusionRays {
 public:
  /// `settings.lines` and `settings.pattern` do not matter.
  static absl::StatusOr<OcclusionRays> Create(std::shared_ptr<const FrameScene> frame,
                                              const OcclusionSettings& settings, int threads);

  /// What AmbientOcclusion::At estimates, by rays of density cos θ / π, a low-discrepancy set of directions
  /// and times (PixelPoints) scrambled by `seed`. With fall-off, each ray is as long as 1 - ρ asks for with
  /// another number between 0 and 1.
  double At(uint32_t triangle, double b1, double b2, int rays, uint64_t seed) const;

 private:
  OcclusionRays(std::shared_ptr<const FrameScene> frame, const OcclusionSettings& settings,
                EmbreeFrame embree)
      : frame_(std::move(frame)), settings_(settings), embree_(std::move(embree)) {}

  std::shared_ptr<const FrameScene> frame_;
  OcclusionSettings settings_;
  EmbreeFrame embree_;
};

}  // namespace shutterline::engine
