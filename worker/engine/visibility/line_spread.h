#pragma once

#include <array>
#include <cstdint>

#include "common/math/tolerance.h"
#include "worker/engine/sampling/pixel_filter.h"

namespace shutterline::engine {

/// How what a tile's lines see is spread over the pixels under a filter that is wider than a pixel: exactly
/// along a line, and across it as if all of the strip around the line saw the same.
///
/// Weights are whole numbers. Those of neighbouring pieces of a line add up exactly, those of what all pixels
/// take of a piece are proportional to its length, and those of all that a pixel may see add up to
/// PixelTotal(). They are doubles, below 2^53 with all instants together. See docs/math/line_samples.md.
class LineSpread {
 public:
  using Weights = std::array<double, PixelFilter::kMostTaps>;  ///< By tap of the filter.

  /// For families of `lines` lines a pixel, a power of two up to kMostLines, at `instants` instants. The
  /// filter must outlive it.
  LineSpread(const PixelFilter& filter, int lines, int64_t instants);

  static constexpr int kMostLines = 16;

  int reach() const { return filter_.reach(); }
  int taps() const { return filter_.taps(); }

  /// Of a piece of a line within one step, subpixels.
  void Along(int32_t begin, int32_t end, Weights& weights) const {
    const int32_t step = begin & ~(kSubpixelsPerPixel - 1);
    Weights rest;
    From(begin - step, weights);
    From(end - step, rest);
    for (size_t k = 0; k < size_t(taps()); ++k) weights[k] -= rest[k];
  }
  /// Of a step of a line from a subpixel of it to its end.
  void From(int32_t subpixel, Weights& weights) const {
    const int32_t at = (subpixel + (int32_t{1} << position_shift_ >> 1)) >> position_shift_;
    const int32_t cell = at >> cell_shift_;
    const PixelFilter::Cell& shares = filter_.At(cell);
    const auto in_cell = double(((cell + 1) << cell_shift_) - at);
    for (size_t k = 0; k < size_t(taps()); ++k) {
      weights[k] = shares.later[k] * cell_length_ + shares.share[k] * in_cell;
    }
  }
  /// Of a whole step.
  double Whole(int tap) const { return filter_.Sum(tap) * cell_length_; }

  /// Across a line that lies in strip `strip` of its pixel's `lines`.
  uint32_t Across(int strip, int tap) const { return across_[size_t(strip)][size_t(tap)]; }

  /// The strip of a line that lies `within_pixel`, in [0, 1), of a pixel from its border.
  int StripOf(double within_pixel) const { return int(within_pixel * lines_); }

  /// The weight of all that a pixel may see on the lines of two families.
  uint64_t PixelTotal() const { return pixel_total_; }

 private:
  const PixelFilter& filter_;
  int lines_;
  int position_shift_, cell_shift_;
  double cell_length_;  ///< In units of position.
  uint64_t pixel_total_;
  std::array<std::array<uint32_t, PixelFilter::kMostTaps>, kMostLines> across_{};
};

}  // namespace shutterline::engine
