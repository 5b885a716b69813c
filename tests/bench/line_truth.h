#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <vector>

#include "common/job/render_settings.h"
#include "tests/bench/point_probe.h"
#include "tests/bench/tile_subset.h"

namespace shutterline::bench {

/// What is held against the rays.
enum class Sight {
  kSlices,   ///< Lines at instants, by the plain kernels (segment, envelope).
  kPatches,  ///< The patches of the resolver `paper` at its defaults, at any time.
};

/// Single samples (x, y, t) on the line samples: what the engine sees there against what a ray sees.
struct LineTruth {
  int64_t samples = 0;
  int64_t same = 0;          ///< The same triangle, or background in both.
  int64_t same_or_tied = 0;  ///< Or another whose depth differs by less than 1e-6 of the depth range.
  double near = 0, far = 0;  ///< Range of distances that rays met, metres.
  /// |distance − the ray's| / (far − near), of samples where both hit.
  std::vector<float> depth_errors = {};
};

/// About `samples` samples, drawn uniformly along the lines of `settings.pattern` in the tiles, for slices at
/// the instants at which they are resolved (`instants` of them on every line), for patches at random times.
absl::StatusOr<LineTruth> MeasureLineTruth(const PointProbe& probe, const RenderSettings& settings,
                                           const TileSubset& subset, int64_t samples, int instants,
                                           int threads, Sight sight = Sight::kSlices);

/// How much of the pictures of the vector resolver and of the plain kernels shows different triangles, with
/// one instant a line: half the sum of the differences of weights, over all weights. In a pixel only a few
/// steps of a line go into a triangle's weight, so next to nothing cancels; so the vector resolver's own
/// accuracy differs from LineTruth's of slices by about this much, and hardly by more.
absl::StatusOr<double> MeasureVectorDifference(const engine::FrameScene& frame_scene, RenderSettings settings,
                                               const TileSubset& subset, int threads);

}  // namespace shutterline::bench
