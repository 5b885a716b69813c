#include "worker/engine/slice/spread_sums.h"

#include <cmath>

namespace shutterline::engine {

void SpreadSums::Begin(const LineSpread& spread, const LineClass& lines, const LineGroup& group) {
  spread_ = &spread;
  lines_ = &lines;
  group_ = &group;
  taps_ = size_t(spread.taps());
  steps_ = size_t(lines.length) + 1;  // Colours may change at the very end.
  by_tap_.assign(kLanes * steps_ * taps_, Color{});
  points_.clear();
  change_.assign(kLanes * (steps_ + 1), Color{});
}

void SpreadSums::ShareAlong(const LineSpread& spread, int32_t begin, int32_t end, int32_t from, int32_t to,
                            LineSpread::Weights& weights) {
  spread.Along(begin, end, weights);
  const int64_t length = end - begin;
  for (size_t k = 0; k < size_t(spread.taps()); ++k) {
    const auto whole = int64_t(weights[k]);
    weights[k] = double(whole * to / length - whole * from / length);
  }
}

SpreadSums::Strip SpreadSums::StripOf(int row, int step) const {
  const double middle = lines_->lines[size_t(row)].intercept + lines_->axes.slope * (step + 0.5);
  const double pixel = std::floor(middle);
  return {int(pixel), spread_->StripOf(middle - pixel)};
}

void SpreadSums::Flush(int lane, const TileRect& grown, ColorFilm& film) const {
  const int row = group_->first_row + lane;
  const TileLine& line = lines_->lines[size_t(row)];
  const Color* const by_tap = by_tap_.data() + size_t(lane) * steps_ * taps_;
  const Color* const changes = change_.data() + size_t(lane) * (steps_ + 1);
  const int taps = int(taps_), reach = spread_->reach();
  const bool major_is_x = lines_->axes.major_is_x;
  const int length = major_is_x ? grown.width : grown.height;
  const int breadth = major_is_x ? grown.height : grown.width;
  Color whole{};
  for (int step = line.first_step; step < line.end_step; ++step) {
    for (size_t c = 0; c < 4; ++c) whole[c] += changes[step][c];
    // Where nothing is, drop what rounding has left of the radiance.
    if (whole[3] == 0) whole = {};
    const auto [minor, strip] = StripOf(row, step);
    for (int k = 0; k < taps; ++k) {
      const int column = step + k - reach;
      if (column < reach || column >= length - reach) continue;
      Color sum = by_tap[size_t(step) * taps_ + size_t(k)];
      for (size_t c = 0; c < 4; ++c) sum[c] += whole[c] * spread_->Whole(k);
      if (!points_.empty()) {
        const Color& points = points_[(size_t(lane) * steps_ + size_t(step)) * taps_ + size_t(k)];
        for (size_t c = 0; c < 4; ++c) sum[c] += points[c];
      }
      if (sum[3] == 0) continue;
      for (int d = 0; d < taps; ++d) {
        const int to = minor + d - reach;
        const uint32_t weight = spread_->Across(strip, d);
        if (weight == 0 || to < reach || to >= breadth - reach) continue;
        Color& pixel = film.At(major_is_x ? to * grown.width + column : column * grown.width + to);
        for (size_t c = 0; c < 4; ++c) pixel[c] += weight * sum[c];
      }
    }
  }
}

}  // namespace shutterline::engine
