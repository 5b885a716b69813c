#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <memory>
#include <utility>

#include "common/job/occlusion_settings.h"
#include "worker/engine/occlusion/hemisphere_lines.h"
#include "worker/engine/occlusion/occluder_tree.h"
#include "worker/engine/occlusion/receiver.h"
#include "worker/engine/scene/frame_scene.h"

namespace shutterline::engine {

/// How much of its hemisphere a point of a moving surface sees, after gribel2011, section 6: the hemisphere
/// is cut by planes through the point, and along each of these line samples the occlusion is exact. Each line
/// has an instant of its own, so lines see a frame that stands still; together they see the shutter.
/// docs/math/occlusion.md derives it.
///
/// Opaque triangles occlude, with both sides; layers do not. Immutable; any number of threads may ask.
class AmbientOcclusion {
 public:
  /// Builds with up to `threads` threads. INVALID_ARGUMENT where settings are out of their range;
  /// RESOURCE_EXHAUSTED where memory is not enough.
  static absl::StatusOr<AmbientOcclusion> Create(std::shared_ptr<const FrameScene> frame,
                                                 const OcclusionSettings& settings, int threads);

  /// 1 - o of Eq. 1: the part of the cosine-weighted hemisphere that is open, in [0, 1], 1 where nothing
  /// occludes; with fall-off, near occluders count more. The point is (1 - b1 - b2) v0 + b1 v1 + b2 v2 and
  /// moves with the triangle. The hemisphere is that of the interpolated normal, on the camera's side at
  /// mid-shutter; what lies below the triangle's own plane does not occlude. 1 for triangles without area.
  ///
  /// A function of the arguments, the frame and the settings alone: the same bits on any thread, processor,
  /// and for any order of the other triangles. The lines are turned from pixel to pixel.
  double At(uint32_t triangle, double b1, double b2) const;

  /// The same with lines shifted as the caller says; the mean over all shifts is free of the lines' error.
  double At(uint32_t triangle, double b1, double b2, const LineShifts& shifts) const;

 private:
  AmbientOcclusion(std::shared_ptr<const FrameScene> frame, const OcclusionSettings& settings,
                   OccluderTree tree)
      : frame_(std::move(frame)), settings_(settings), tree_(std::move(tree)) {}

  double Evaluate(const Receiver& receiver, uint32_t triangle, const LineShifts& shifts) const;

  std::shared_ptr<const FrameScene> frame_;
  OcclusionSettings settings_;
  OccluderTree tree_;
};

}  // namespace shutterline::engine
