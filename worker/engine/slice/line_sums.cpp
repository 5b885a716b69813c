#include "worker/engine/slice/line_sums.h"

#include <algorithm>
#include <numeric>

namespace shutterline::engine {

void LineSums::Begin(const TileMesh& mesh, const LineClass& lines, const LineGroup& group, TileColors& colors,
                     const LineSpread* spread) {
  mesh_ = &mesh;
  lines_ = &lines;
  group_ = &group;
  colors_ = &colors;
  has_points_ = false;
  spreads_ = spread != nullptr;
  if (spreads_) {
    spread_sums_.Begin(*spread, lines, group);
    return;
  }
  if (colors.film() == nullptr) return;
  for (int lane = 0; lane < group.lanes; ++lane) {
    std::fill_n(lane_sums_[size_t(lane)].begin(), size_t(lines.length) + 2, Color{});
    std::fill_n(lane_shares_[size_t(lane)].begin(), size_t(lines.length), Color{});
  }
}

void LineSums::AddSmooth(int32_t begin, int32_t end, uint32_t index, const LinePosition& position,
                         double weight) {
  if (colors_->IsByPoints(index)) {
    if (spreads_) {
      has_points_ = true;
      colors_->film()->points().SpreadAlong(colors_->PreparedOf(index), position,
                                            {begin, end, colors_->PartsLog2(index)}, weight,
                                            spread_sums_.spread(), spread_sums_.points());
      return;
    }
    if (!has_points_) BeginPoints();
    colors_->film()->points().AddAlong(colors_->PreparedOf(index), position,
                                       {begin, end, colors_->PartsLog2(index)}, weight, points_of_lane_);
    return;
  }
  for (int32_t at = begin; at < end;) {
    const int step = at >> kSubpixelBits;
    const auto next = int32_t(std::min<int64_t>(end, int64_t{step + 1} << kSubpixelBits));
    // The colour in the middle of the part stands for its mean.
    const double l = (double(at) + double(next)) * (0.5 / kSubpixelsPerPixel);
    const Color color = colors_->ColorAt(index, position, l);
    if (spreads_) {
      spread_sums_.AddPiece(at, next, color, weight);
      at = next;
      continue;
    }
    const double length = weight * double(next - at);
    Color& share = shares_of_lane_[step];
    for (size_t c = 0; c < 4; ++c) share[c] += length * color[c];
    at = next;
  }
}

void LineSums::BeginPoints() {
  has_points_ = true;
  for (int lane = 0; lane < group_->lanes; ++lane) {
    std::fill_n(lane_points_[size_t(lane)].begin(), size_t(lines_->length), Color{});
  }
}

void LineSums::End(PairWeights& weights) {
  if (has_points_) colors_->film()->points().Finish();
  for (int lane = 0; lane < group_->lanes; ++lane) {
    if (spreads_ && colors_->film() != nullptr) {
      spread_sums_.Flush(lane, mesh_->rect(), *colors_->film());
    } else if (colors_->film() != nullptr) {
      FlushColors(lane);
    }
    if (apart_[size_t(lane)].empty()) continue;
    if (spreads_) {
      FlushApart<true>(lane, weights);
    } else {
      FlushApart<false>(lane, weights);
    }
  }
}

void LineSums::FlushColors(int lane) {
  const int row = group_->first_row + lane;
  const TileLine& line = lines_->lines[size_t(row)];
  Color sum{0, 0, 0, 0};
  for (int step = line.first_step; step < line.end_step; ++step) {
    const Color& change = lane_sums_[size_t(lane)][size_t(step)];
    for (size_t c = 0; c < 4; ++c) sum[c] += change[c];
    // Where nothing is, drop what rounding has left of the radiance.
    if (sum[3] == 0) sum = {0, 0, 0, 0};
    Color share = lane_shares_[size_t(lane)][size_t(step)];
    if (has_points_) {
      const Color& points = lane_points_[size_t(lane)][size_t(step)];
      for (size_t c = 0; c < 4; ++c) share[c] += points[c];
    }
    if (sum[3] + share[3] == 0) continue;
    Color& pixel = colors_->film()->At(lines_->PixelOf(row, step));
    for (size_t c = 0; c < 4; ++c) pixel[c] += sum[c] + share[c];
  }
}

template <bool kSpread>
void LineSums::FlushApart(int lane, PairWeights& weights) {
  std::vector<Piece>& pieces = apart_[size_t(lane)];
  order_.resize(pieces.size());
  std::iota(order_.begin(), order_.end(), 0u);
  std::sort(order_.begin(), order_.end(), [&](uint32_t a, uint32_t b) {
    const Piece& p = pieces[a];
    const Piece& q = pieces[b];
    return p.index != q.index ? p.index < q.index : p.bin != q.bin ? p.bin < q.bin : a < b;
  });
  for (size_t i = 0; i < order_.size();) {
    const Piece& first = pieces[order_[i]];
    first_step_ = kMaxLinePixels;
    last_step_ = -1;
    for (; i < order_.size(); ++i) {
      const Piece& piece = pieces[order_[i]];
      if (piece.index != first.index || piece.bin != first.bin) break;
      const int from_step = piece.begin >> kSubpixelBits;
      const int to_step = (piece.end - 1) >> kSubpixelBits;
      first_step_ = std::min(first_step_, from_step);
      last_step_ = std::max(last_step_, to_step);
      for (int step = from_step; step <= to_step; ++step) {
        const int32_t from = std::max(piece.begin, step << kSubpixelBits);
        const int64_t to = std::min<int64_t>(piece.end, int64_t{step + 1} << kSubpixelBits);
        const int64_t length = piece.share.subpixels == kWhole ? to - from : piece.share.subpixels;
        const uint64_t weight = uint64_t(length) * uint64_t(piece.weight);
        const double middle = (double(from) + double(to)) * (0.5 / kSubpixelsPerPixel);
        Share& share = shares_[size_t(step)];
        share.weight += weight;
        for (size_t c = 0; c < 3; ++c) {
          share.position[c] += double(weight) * (piece.position.at[c] + piece.position.per_pixel[c] * middle);
        }
        if constexpr (kSpread) SpreadPart(piece, step, from, int32_t(to));
      }
    }
    FlushTriangle<kSpread>(lane, first.index, first.bin, weights);
  }
  pieces.clear();
}

template <bool kSpread>
void LineSums::FlushTriangle(int lane, uint32_t index, uint16_t bin, PairWeights& weights) {
  const TileMeshTriangle& triangle = mesh_->triangles()[index];
  const bool is_colored = colors_->keeps_pairs() && colors_->KindOf(index) != ColorKind::kApart;
  PairWeights& pairs = is_colored ? colors_->film()->pairs() : weights;
  for (int step = first_step_; step <= last_step_; ++step) {
    Share& share = shares_[size_t(step)];
    if (share.weight == 0) continue;
    PixelPair pair{
        .triangle = triangle.id, .bin = bin, .bins_log2 = triangle.shading_bins_log2, .weight = share.weight};
    if (triangle.needs_position) {
      const double over = share.position[2];
      // Rounding must not leave the triangle.
      pair.b1 = ClampedFromZero(share.position[0] / over, 1);
      pair.b2 = ClampedFromZero(share.position[1] / over, 1 - pair.b1);
    }
    const uint32_t number = pairs.Add(lines_->PixelOf(group_->first_row + lane, step), pair);
    if constexpr (kSpread) SpreadPair(group_->first_row + lane, step, pairs.SpreadOf(number));
    share = {};
  }
}

void LineSums::SpreadPart(const Piece& piece, int step, int32_t from, int32_t to) {
  LineSpread::Weights weights;
  if (piece.share.subpixels == kWhole) {
    spread_sums_.spread().Along(from, to, weights);
  } else {
    SpreadSums::ShareAlong(spread_sums_.spread(), from, to, piece.share.before,
                           piece.share.before + piece.share.subpixels, weights);
  }
  for (size_t k = 0; k < size_t(spread_sums_.spread().taps()); ++k) {
    taps_[size_t(step)][k] += uint64_t(weights[k]) * uint64_t(piece.weight);
  }
}

void LineSums::SpreadPair(int row, int step, std::span<uint64_t> spread) {
  const LineSpread& filter = spread_sums_.spread();
  const auto taps = size_t(filter.taps());
  const int strip = spread_sums_.StripOf(row, step).strip;
  for (size_t d = 0; d < taps; ++d) {
    for (size_t k = 0; k < taps; ++k) {
      const size_t to = lines_->axes.major_is_x ? d * taps + k : k * taps + d;
      spread[to] += taps_[size_t(step)][k] * filter.Across(strip, int(d));
    }
  }
  taps_[size_t(step)] = {};
}

}  // namespace shutterline::engine
