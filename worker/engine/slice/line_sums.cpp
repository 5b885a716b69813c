#include "worker/engine/slice/line_sums.h"

#include <algorithm>
#include <numeric>

namespace shutterline::engine {

void LineSums::BeginTile(const TileMesh& mesh, const LinePattern& pattern, PairWeights& weights,
                         FlatFilm* flat) {
  mesh_ = &mesh;
  pattern_ = &pattern;
  weights_ = &weights;
  flat_ = flat;
  if (flat == nullptr) return;
  colors_.resize(std::max(colors_.size(), mesh.triangles().size()));
  known_.assign(mesh.triangles().size(), 0);
}

void LineSums::BeginGroup(const LineGroup& group) {
  group_ = &group;
  if (flat_ == nullptr) return;
  for (int lane = 0; lane < group.lanes; ++lane) lane_sums_[size_t(lane)].fill({0, 0, 0, 0});
}

void LineSums::Shade(uint32_t index) {
  const V3f color = flat_->Shade(mesh_->triangles()[index].id);
  colors_[index] = {double(color.x), double(color.y), double(color.z), 1};
  known_[index] = 1;
}

void LineSums::EndGroup(int64_t weight_of_instant) {
  for (int lane = 0; lane < group_->lanes; ++lane) {
    if (flat_ != nullptr) FlushFlat(lane, weight_of_instant);
    if (!apart_[size_t(lane)].empty()) FlushApart(lane, weight_of_instant);
  }
}

int64_t LineSums::PixelOf(int lane, int step) const {
  const int minor = pattern_->MinorPixel(group_->lines[size_t(lane)], step);
  return group_->major_is_x ? int64_t{minor} * mesh_->rect().width + step
                            : int64_t{step} * mesh_->rect().width + minor;
}

void LineSums::FlushFlat(int lane, int64_t weight_of_instant) {
  const TileLine& line = group_->lines[size_t(lane)];
  Color sum{0, 0, 0, 0};
  for (int step = line.first_step; step < line.end_step; ++step) {
    const Color& change = lane_sums_[size_t(lane)][size_t(step)];
    for (size_t c = 0; c < 4; ++c) sum[c] += change[c];
    if (sum[3] == 0) {
      sum = {0, 0, 0, 0};  // Nothing is there: drop what rounding has left of the radiance.
      continue;
    }
    Color& pixel = flat_->At(PixelOf(lane, step));
    for (size_t c = 0; c < 4; ++c) pixel[c] += sum[c] * double(weight_of_instant);
  }
}

void LineSums::FlushApart(int lane, int64_t weight_of_instant) {
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
        const uint64_t weight = uint64_t(to - from) * uint64_t(piece.weight);
        const double middle = (double(from) + double(to)) * (0.5 / kSubpixelsPerPixel);
        Share& share = shares_[size_t(step)];
        share.weight += weight;
        for (size_t c = 0; c < 3; ++c) {
          share.position[c] += double(weight) * (piece.position.at[c] + piece.position.per_pixel[c] * middle);
        }
      }
    }
    FlushTriangle(lane, first.index, first.bin, weight_of_instant);
  }
  pieces.clear();
}

void LineSums::FlushTriangle(int lane, uint32_t index, uint16_t bin, int64_t weight_of_instant) {
  const TileMeshTriangle& triangle = mesh_->triangles()[index];
  for (int step = first_step_; step <= last_step_; ++step) {
    Share& share = shares_[size_t(step)];
    if (share.weight == 0) continue;
    PixelPair pair{.triangle = triangle.id,
                   .bin = bin,
                   .bins_log2 = triangle.shading_bins_log2,
                   .weight = share.weight * uint64_t(weight_of_instant)};
    if (triangle.needs_position) {
      const double over = share.position[2];
      const double b1 = share.position[0] / over;
      const double b2 = share.position[1] / over;
      // Rounding must not leave the triangle.
      pair.b1 = b1 > 0 ? std::min(b1, 1.0) : 0;
      pair.b2 = b2 > 0 ? std::min(b2, 1 - pair.b1) : 0;
    }
    weights_->Add(PixelOf(lane, step), pair);
    share = {};
  }
}

}  // namespace shutterline::engine
