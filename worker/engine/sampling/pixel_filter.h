#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/job/render_settings.h"

namespace shutterline::engine {

/// How much of the light at a place of the raster each pixel near it takes. Separable: the shares of a row of
/// pixels are those of this class, and so are those of a column. Immutable.
///
/// A place's shares are f(x - x_i) / sum over j of f(x - x_j), f being the filter's curve and x_i the pixels'
/// middles: divided by their sum, so that all light goes somewhere, once (docs/math/line_samples.md, section
/// 8). They are constant within each of kCells cells of a pixel, and whole numbers that add up to kWhole.
class PixelFilter {
 public:
  static constexpr int kCellsLog2 = 7;
  static constexpr int kCells = 1 << kCellsLog2;
  static constexpr int kWholeLog2 = 8;
  static constexpr int kWhole = 1 << kWholeLog2;
  static constexpr int kMostReach = 4;
  static constexpr int kMostTaps = 2 * kMostReach + 1;

  /// `radius`: pixels, kMinFilterRadius to kMaxFilterRadius.
  PixelFilter(FilterKind kind, double radius);

  /// How many pixels to either side of a place's own take a share of it.
  int reach() const { return reach_; }
  /// Pixels that take a share: tap k is the one that lies k - reach() further on.
  int taps() const { return 2 * reach_ + 1; }

  /// Of all places of a cell, of a pixel's kCells; by tap.
  struct Cell {
    std::array<double, kMostTaps> share{};  ///< Of kWhole.
    std::array<double, kMostTaps> later{};  ///< Sums of `share` over the pixel's later cells.
  };
  /// `cell` may be kCells: an empty one that ends the pixel.
  const Cell& At(int cell) const { return cells_[size_t(cell)]; }
  /// Over all cells of a pixel, of kCells · kWhole.
  double Sum(int tap) const { return cells_[0].share[size_t(tap)] + cells_[0].later[size_t(tap)]; }
  /// Over the cells of strip `strip` of `strips` equal ones, a power of two up to kCells.
  uint32_t SumOfStrip(int strips, int strip, int tap) const;

  /// The place that has the part `u`, in [0, 1), of all that a pixel takes before it: pixels from the pixel's
  /// lower border. Uniform `u` makes places as dense as the pixel's shares.
  double PlaceOf(double u) const;

 private:
  int reach_ = 0;
  std::array<Cell, kCells + 1> cells_{};
  std::vector<uint32_t> before_;  ///< What the pixel takes before each cell of its neighbourhood.
};

/// The integral of the filter's curve from its beginning to x, pixels from its middle; the curve is 1 there,
/// or, cut off and lifted, a little less.
double FilterIntegral(FilterKind kind, double radius, double x);

}  // namespace shutterline::engine
