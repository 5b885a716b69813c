#pragma once

#include <cstdint>
#include <span>

#include "worker/engine/visibility/pair_weights.h"

namespace shutterline::engine {

/// The pairs of a grown tile's pixels as the tile's pixels take them under a filter.
class SpreadPairs {
 public:
  /// Pixels in rows: a tile with `reach` more on all sides.
  struct Grid {
    int width = 0, height = 0;
    int reach = 0;

    int64_t At(int x, int y) const { return int64_t{y} * width + x; }
  };

  /// `pairs` must have been reset for the grid and the filter's taps, and outlive it.
  SpreadPairs(const Grid& grid, const PairWeights& pairs) : grid_(grid), pairs_(pairs) {}

  /// visit(number, pair) of all pairs, by pixel.
  template <typename Visit>
  void ForAll(const Visit& visit) const {
    for (int64_t pixel = 0; pixel < grid_.At(0, grid_.height); ++pixel) {
      pairs_.ForEach(pixel, [&](const PixelPair& pair) { visit(pairs_.NumberOf(pair), pair); });
    }
  }

  /// visit(number, weight) of all pairs that pixel (x, y) of the tile takes something of.
  template <typename Visit>
  void ForReaching(int x, int y, const Visit& visit) const {
    const int taps = 2 * grid_.reach + 1;
    // Of a pair in the tap before, the pixel is the tap after.
    for (int row = 0; row < taps; ++row) {
      for (int column = 0; column < taps; ++column) {
        const auto tap = size_t((taps - 1 - row) * taps + (taps - 1 - column));
        pairs_.ForEach(grid_.At(x + column, y + row), [&](const PixelPair& pair) {
          const uint32_t number = pairs_.NumberOf(pair);
          const uint64_t weight = pairs_.SpreadOf(number)[tap];
          if (weight != 0) visit(number, weight);
        });
      }
    }
  }

 private:
  Grid grid_;
  const PairWeights& pairs_;
};

}  // namespace shutterline::engine
