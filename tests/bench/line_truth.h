#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <vector>

#include "common/job/render_settings.h"
#include "tests/bench/point_probe.h"
#include "tests/bench/tile_subset.h"

namespace shutterline::bench {

/// Single samples (x, y, t) on the line samples: what the slices see there against what a ray sees.
struct LineTruth {
  int64_t samples = 0;
  int64_t same = 0;          ///< The same triangle, or background in both.
  int64_t same_or_tied = 0;  ///< Or another whose depth differs by less than 1e-6 of the depth range.
  double near = 0, far = 0;  ///< Range of distances that rays met, metres.
  /// |distance − the ray's| / (far − near), of samples where both hit.
  std::vector<float> depth_errors = {};
};

/// About `samples` samples, drawn uniformly along the lines of `settings.pattern` in the tiles, at the
/// instants at which the slices are resolved (`instants` of them on every line).
absl::StatusOr<LineTruth> MeasureLineTruth(const PointProbe& probe, const RenderSettings& settings,
                                           const TileSubset& subset, int64_t samples, int instants,
                                           int threads);

}  // namespace shutterline::bench
