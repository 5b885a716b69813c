#pragma once

#include <cstdint>

#include "worker/engine/paper/options.h"
#include "worker/engine/scene/frame_scene.h"

namespace shutterline::engine {

/// How well patches show what lines see, at random points (l, t) of lines, against the exact segments at
/// those instants [gribel2011, figure 15].
struct PatchAccuracy {
  int64_t points = 0;    ///< All.
  int64_t agreeing = 0;  ///< The same triangle or the background in both.

  // On lines on which something moves, where at least one of both sees a triangle.
  int64_t samples = 0;
  int64_t same_triangle = 0;
  /// Off by less than a thousandth of the range of distances that the samples see. A point at which only
  /// one of both sees the background is off.
  int64_t depth_within_thousandth = 0;
  double largest_depth_error = 0;  ///< Of that range, over samples where both see a triangle.

  double Agreement() const { return points == 0 ? 1 : double(agreeing) / double(points); }
  double SameTriangle() const { return samples == 0 ? 1 : double(same_triangle) / double(samples); }
  double DepthWithin() const { return samples == 0 ? 1 : double(depth_within_thousandth) / double(samples); }
};

/// Measures a frame, or of its tiles of 32 × 32 every `stride`-th, `samples_per_line` points on every line.
/// For perspective views.
PatchAccuracy MeasurePatches(const FrameScene& frame, PatternKind pattern, const paper::Options& options,
                             int samples_per_line, uint64_t seed, int stride = 1);

}  // namespace shutterline::engine
