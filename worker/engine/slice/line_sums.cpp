#include "worker/engine/slice/line_sums.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace shutterline::engine {

namespace {

/// Colours are taken as one where they differ by less than this over a triangle: far below what eight bits
/// show.
constexpr double kColorTolerance = 1e-3;

/// Within [0, most]; 0 for what is not a number, as positions on triangles that are all but seen edge-on.
double Clamped(double x, double most) {
  return x > 0 ? std::min(x, most) : 0;
}

}  // namespace

void LineSums::BeginTile(const TileMesh& mesh, const LinePattern& pattern, PairWeights& weights,
                         ColorFilm* film) {
  mesh_ = &mesh;
  pattern_ = &pattern;
  weights_ = &weights;
  film_ = film;
  if (film == nullptr) return;
  const size_t count = mesh.triangles().size();
  kinds_.assign(count, ColorKind::kUnknown);
  if (colors_.size() >= count) return;
  colors_.resize(count);
  smooth_.resize(count);
}

void LineSums::BeginGroup(const LineGroup& group) {
  group_ = &group;
  if (film_ == nullptr) return;
  for (int lane = 0; lane < group.lanes; ++lane) {
    lane_sums_[size_t(lane)].fill({0, 0, 0, 0});
    lane_shares_[size_t(lane)].fill({0, 0, 0, 0});
  }
}

void LineSums::Shade(uint32_t index) {
  const std::optional<ColorNodes> nodes = film_->Shade(mesh_->triangles()[index].id);
  if (!nodes) {
    kinds_[index] = ColorKind::kApart;
    return;
  }
  double range = 0;
  const auto measure = [&](const V3f& color) {
    for (int c = 0; c < 3; ++c) range = std::max(range, std::abs(double(color[c] - nodes->corners[0][c])));
  };
  for (const V3f& color : nodes->corners) measure(color);
  if (nodes->quadratic) {
    for (const V3f& color : nodes->middles) measure(color);
  }
  colors_[index][3] = 1;
  smooth_[index] = {.coefficients = {}, .quadratic = nodes->quadratic};
  for (int c = 0; c < 3; ++c) {
    const auto k = size_t(c);
    const double f0 = nodes->corners[0][c];
    const double f1 = nodes->corners[1][c];
    const double f2 = nodes->corners[2][c];
    colors_[index][k] = range == 0 ? f0 : (f0 + f1 + f2) / 3;
    std::array<Color, 6>& a = smooth_[index].coefficients;
    a[0][k] = f0;
    a[1][k] = f1 - f0;
    a[2][k] = f2 - f0;
    if (!nodes->quadratic) continue;
    // Through the corners and the middles m01, m12, m20.
    const double m01 = nodes->middles[0][c];
    const double m12 = nodes->middles[1][c];
    const double m20 = nodes->middles[2][c];
    a[1][k] = 4 * m01 - 3 * f0 - f1;
    a[2][k] = 4 * m20 - 3 * f0 - f2;
    a[3][k] = 2 * (f0 + f1) - 4 * m01;
    a[4][k] = 4 * (f0 + m12 - m01 - m20);
    a[5][k] = 2 * (f0 + f2) - 4 * m20;
  }
  kinds_[index] = range < kColorTolerance ? ColorKind::kConstant : ColorKind::kSmooth;
}

void LineSums::AddSmooth(int32_t begin, int32_t end, uint32_t index, const LinePosition& position) {
  const Smooth& smooth = smooth_[index];
  const std::array<Color, 6>& a = smooth.coefficients;
  for (int32_t at = begin; at < end;) {
    const int step = at >> kSubpixelBits;
    const auto next = int32_t(std::min<int64_t>(end, int64_t{step + 1} << kSubpixelBits));
    // The colour in the middle of the part stands for its mean. Rounding must not leave the triangle.
    const double l = (double(at) + double(next)) * (0.5 / kSubpixelsPerPixel);
    const double over = 1 / (position.at[2] + position.per_pixel[2] * l);
    const double b1 = Clamped((position.at[0] + position.per_pixel[0] * l) * over, 1);
    const double b2 = Clamped((position.at[1] + position.per_pixel[1] * l) * over, 1 - b1);
    const double weight = weight_ * double(next - at);
    Color& share = shares_of_lane_[step];
    for (size_t c = 0; c < 3; ++c) {
      double color = a[0][c] + b1 * a[1][c] + b2 * a[2][c];
      if (smooth.quadratic) color += b1 * (b1 * a[3][c] + b2 * a[4][c]) + b2 * b2 * a[5][c];
      share[c] += weight * color;
    }
    share[3] += weight;
    at = next;
  }
}

void LineSums::EndGroup(int64_t weight_of_instant) {
  for (int lane = 0; lane < group_->lanes; ++lane) {
    if (film_ != nullptr) FlushColors(lane, weight_of_instant);
    if (!apart_[size_t(lane)].empty()) FlushApart(lane, weight_of_instant);
  }
}

int64_t LineSums::PixelOf(int lane, int step) const {
  const int minor = pattern_->MinorPixel(group_->lines[size_t(lane)], step);
  return group_->major_is_x ? int64_t{minor} * mesh_->rect().width + step
                            : int64_t{step} * mesh_->rect().width + minor;
}

void LineSums::FlushColors(int lane, int64_t weight_of_instant) {
  const TileLine& line = group_->lines[size_t(lane)];
  Color sum{0, 0, 0, 0};
  for (int step = line.first_step; step < line.end_step; ++step) {
    const Color& change = lane_sums_[size_t(lane)][size_t(step)];
    for (size_t c = 0; c < 4; ++c) sum[c] += change[c];
    // Where nothing is, drop what rounding has left of the radiance.
    if (sum[3] == 0) sum = {0, 0, 0, 0};
    const Color& share = lane_shares_[size_t(lane)][size_t(step)];
    if (sum[3] + share[3] == 0) continue;
    Color& pixel = film_->At(PixelOf(lane, step));
    for (size_t c = 0; c < 4; ++c) pixel[c] += (sum[c] + share[c]) * double(weight_of_instant);
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
      // Rounding must not leave the triangle.
      pair.b1 = Clamped(share.position[0] / over, 1);
      pair.b2 = Clamped(share.position[1] / over, 1 - pair.b1);
    }
    weights_->Add(PixelOf(lane, step), pair);
    share = {};
  }
}

}  // namespace shutterline::engine
