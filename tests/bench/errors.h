#pragma once

#include <absl/status/statusor.h>

#include <vector>

#include "common/image/metrics.h"
#include "tests/bench/masks.h"
#include "tests/bench/references.h"

namespace shutterline::bench {

/// Every figure that the report has for a setting's pictures.
struct ErrorFigures {
  UnbiasedError whole;
  /// Over masks; without pixels where the mask is empty.
  UnbiasedError moving, static_edges, disocclusions;
  /// Of a random method, from its independent pictures: D less the variance of one. NaN for one picture.
  double bias_squared = 0;
  // Against the mean of the halves, whose noise they contain.
  double relative_mse = 0, psnr = 0;
  double flip_ldr = 0, flip_hdr = 0;
};

/// D over the mean of several pictures' D, their standard errors averaged: each picture's own error counts,
/// not that of their mean. INVALID_ARGUMENT where a picture holds a NaN or an infinity.
absl::StatusOr<ErrorFigures> MeasureErrors(const std::vector<Image>& pictures,
                                           const ReferenceHalves& reference, const BenchMasks& masks,
                                           int threads);

/// Mean FLIP over the tiles of two stacks, each tile a picture of its own; of more than kFlipTiles tiles,
/// over that many, evenly spread. HDR at the exposures of the reference's whole stack.
inline constexpr int kFlipTiles = 12;
struct FlipFigures {
  double ldr = 0, hdr = 0;
};
absl::StatusOr<FlipFigures> MeasureFlip(const Image& test, const Image& reference, int threads);

}  // namespace shutterline::bench
