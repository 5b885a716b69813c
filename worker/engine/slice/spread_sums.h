#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/job/tile.h"
#include "worker/engine/slice/line_class.h"
#include "worker/engine/visibility/color_film.h"
#include "worker/engine/visibility/line_spread.h"

namespace shutterline::engine {

/// What a group's lines see of known colours, spread over the pixels that a filter reaches: what LineSums
/// keeps by step is kept here by step and tap, the column that takes it. Rows are shared out when the group
/// is done. Keeps its memory.
class SpreadSums {
 public:
  using Color = std::array<double, 4>;

  /// Begins a group; `spread` must last until it is done.
  void Begin(const LineSpread& spread, const LineClass& lines, const LineGroup& group);

  const LineSpread& spread() const { return *spread_; }

  void BeginLane(int lane) {
    by_tap_of_lane_ = by_tap_.data() + size_t(lane) * steps_ * taps_;
    change_of_lane_ = change_.data() + size_t(lane) * (steps_ + 1);
  }
  /// From subpixel x on the lane's colour is another.
  void Change(int32_t x, const Color& change) {
    const auto step = size_t(x >> kSubpixelBits);
    LineSpread::Weights weights;
    spread_->From(x & (kSubpixelsPerPixel - 1), weights);
    Add(step, change, weights);
    Color& next = change_of_lane_[step + 1];
    for (size_t c = 0; c < 4; ++c) next[c] += change[c];
  }
  /// A piece within one step has a colour, `weight` times.
  void AddPiece(int32_t begin, int32_t end, Color color, double weight) {
    LineSpread::Weights weights;
    spread_->Along(begin, end, weights);
    for (double& value : color) value *= weight;
    Add(size_t(begin >> kSubpixelBits), color, weights);
  }
  /// The same of its subpixels [from, to), counted in any order: shares of a piece add up to it exactly.
  void AddShare(int32_t begin, int32_t end, int32_t from, int32_t to, Color color, double weight) {
    LineSpread::Weights weights;
    ShareAlong(*spread_, begin, end, from, to, weights);
    for (double& value : color) value *= weight;
    Add(size_t(begin >> kSubpixelBits), color, weights);
  }
  static void ShareAlong(const LineSpread& spread, int32_t begin, int32_t end, int32_t from, int32_t to,
                         LineSpread::Weights& weights);

  /// Sums of the lane by step and tap of their own, for PointColors, which may come late.
  Color* points() {
    if (points_.empty()) points_.assign(by_tap_.size(), Color{});
    return points_.data() + (by_tap_of_lane_ - by_tap_.data());
  }

  /// Where a step of a line lies across it: the row of pixels, and which of its strips.
  struct Strip {
    int row = 0, strip = 0;
  };
  Strip StripOf(int row, int step) const;

  /// The lane's sums go to the film, in the pixels of a tile that is grown by the filter's reach.
  void Flush(int lane, const TileRect& grown, ColorFilm& film) const;

 private:
  void Add(size_t step, const Color& color, const LineSpread::Weights& weights) {
    Color* const sums = by_tap_of_lane_ + step * taps_;
    for (size_t k = 0; k < taps_; ++k) {
      for (size_t c = 0; c < 4; ++c) sums[k][c] += weights[k] * color[c];
    }
  }

  const LineSpread* spread_ = nullptr;
  const LineClass* lines_ = nullptr;
  const LineGroup* group_ = nullptr;
  size_t taps_ = 0, steps_ = 0;
  // By lane, then step: what is added, by tap; and changes that hold from the step's beginning on.
  std::vector<Color> by_tap_, change_;
  std::vector<Color> points_;  // As by_tap_; empty where there are none.
  Color* by_tap_of_lane_ = nullptr;
  Color* change_of_lane_ = nullptr;
};

}  // namespace shutterline::engine
