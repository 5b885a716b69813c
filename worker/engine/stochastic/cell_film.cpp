#include "worker/engine/stochastic/cell_film.h"

#include <algorithm>
#include <tuple>

#include "worker/engine/shading/footprint.h"
#include "worker/engine/shading/shade.h"

namespace shutterline::engine {
namespace {

/// A pixel with more pairs than this finds them through a hash table.
constexpr uint32_t kLongestSearch = 24;

constexpr size_t PixelOf(int x, int y) {
  return size_t(y) * kCellSize + size_t(x);
}

}  // namespace

void CellFilm::Reset(const FrameScene& frame, const CellTriangles& cell) {
  constexpr size_t kPixels = size_t{kCellSize} * kCellSize;
  frame_ = &frame;
  cell_ = &cell;
  varying_ = std::any_of(cell.triangles.begin(), cell.triangles.end(),
                         [](const CellTriangle& t) { return t.needs_position; });
  colors_.assign(cell.triangles.size() + 1, Rgba{.a = -1});
  colors_[0] = {};
  group_.assign(kPixels, Rgba{});
  total_.assign(kPixels, {});
  if (!varying_) return;
  pairs_.assign(1, Pair{});
  first_pair_.assign(kPixels, 0);
  latest_pair_.assign(kPixels, 0);
  pair_count_.assign(kPixels, 0);
  index_.clear();
}

const CellFilm::Rgba& CellFilm::ColorOf(uint32_t seen) {
  Rgba& color = colors_[seen];
  if (color.a < 0) {
    const V3f radiance = Shade(*frame_, cell_->triangles[seen - 1].id, Barycentric{}, Footprint{});
    color = {radiance.x, radiance.y, radiance.z, 1};
  }
  return color;
}

void CellFilm::AddPass(const Pass& pass, const PassBuffers& buffers) {
  if (varying_) {
    AddVarying(pass, buffers);
  } else {
    AddConstant(pass, buffers);
  }
  const int end = pass.first_stratum + pass.shape.strata;
  if (end % kMostPassStrata != 0 && end < pass.spp) return;
  for (int y = pass.y0; y < pass.y1; ++y) {
    for (size_t i = PixelOf(pass.x0, y); i < PixelOf(pass.x1, y); ++i) {
      Rgba& group = group_[i];
      std::array<double, 4>& total = total_[i];
      total[0] += double(group.r);
      total[1] += double(group.g);
      total[2] += double(group.b);
      total[3] += double(group.a);
      group = {};
    }
  }
}

void CellFilm::AddConstant(const Pass& pass, const PassBuffers& buffers) {
  const int strata = std::min(pass.shape.strata, pass.spp - pass.first_stratum);
  const uint32_t* const seen = buffers.seen.get();
  for (int y = pass.y0; y < pass.y1; ++y) {
    for (int x = pass.x0; x < pass.x1; ++x) {
      Rgba sum = group_[PixelOf(x, y)];
      for (int s = 0; s < strata; ++s) {
        const uint32_t what = seen[SampleIndex(pass.shape, x, y, s)];
        const Rgba& color = ColorOf(what);
        sum.r += color.r;
        sum.g += color.g;
        sum.b += color.b;
        sum.a += color.a;
      }
      group_[PixelOf(x, y)] = sum;
    }
  }
}

void CellFilm::AddVarying(const Pass& pass, const PassBuffers& buffers) {
  const int strata = std::min(pass.shape.strata, pass.spp - pass.first_stratum);
  for (int y = pass.y0; y < pass.y1; ++y) {
    for (int x = pass.x0; x < pass.x1; ++x) {
      const int pixel = int(PixelOf(x, y));
      for (int s = 0; s < strata; ++s) {
        const size_t at = SampleIndex(pass.shape, x, y, s);
        const uint32_t what = buffers.seen[at];
        if (what == 0) continue;
        const CellTriangle& triangle = cell_->triangles[what - 1];
        Rgba& sum = group_[size_t(pixel)];
        if (!triangle.needs_position) {
          const Rgba& color = ColorOf(what);
          sum = {sum.r + color.r, sum.g + color.g, sum.b + color.b, sum.a + 1};
          continue;
        }
        sum.a += 1;
        uint32_t bin = 0;
        if (triangle.shading_bins_log2 > 0) {
          const auto bins = uint32_t{1} << triangle.shading_bins_log2;
          const float t = 0.5f * buffers.tau[at] + 0.5f;
          bin = std::min(uint32_t(std::max(t, 0.0f) * float(bins)), bins - 1);
        }
        Pair& pair = PairOf(pixel, what - 1, bin);
        ++pair.count;
        pair.b1 += double(buffers.b1[at]);
        pair.b2 += double(buffers.b2[at]);
      }
    }
  }
}

CellFilm::Pair& CellFilm::PairOf(int pixel, uint32_t triangle, uint32_t bin) {
  const auto matches = [&](const Pair& p) { return p.triangle == triangle && p.bin == bin; };
  uint32_t& latest = latest_pair_[size_t(pixel)];
  if (latest != 0 && matches(pairs_[latest])) return pairs_[latest];
  const std::array<uint32_t, 3> key{uint32_t(pixel), triangle, bin};
  uint32_t& count = pair_count_[size_t(pixel)];
  uint32_t found = 0;
  if (count <= kLongestSearch) {
    for (found = first_pair_[size_t(pixel)]; found != 0; found = pairs_[found].next) {
      if (matches(pairs_[found])) break;
    }
  } else if (const auto it = index_.find(key); it != index_.end()) {
    found = it->second;
  }
  if (found == 0) {
    found = uint32_t(pairs_.size());
    pairs_.push_back({.triangle = triangle, .bin = bin, .next = first_pair_[size_t(pixel)]});
    first_pair_[size_t(pixel)] = found;
    if (++count == kLongestSearch + 1) {
      for (uint32_t i = found; i != 0; i = pairs_[i].next) {
        index_[{uint32_t(pixel), pairs_[i].triangle, pairs_[i].bin}] = i;
      }
    } else if (count > kLongestSearch) {
      index_[key] = found;
    }
  }
  latest = found;
  return pairs_[found];
}

V3f CellFilm::ShadePair(const Pair& pair) const {
  const CellTriangle& triangle = cell_->triangles[pair.triangle];
  const FrameTriangle& corners = frame_->triangles[triangle.id];
  const FramePrimitive& primitive = frame_->primitives[corners.primitive];
  // Rounding may leave the triangle.
  Barycentric at;
  at.b1 = std::clamp(pair.b1 / pair.count, 0.0, 1.0);
  at.b2 = std::clamp(pair.b2 / pair.count, 0.0, 1.0 - at.b1);
  const double t = (pair.bin + 0.5) / double(1u << triangle.shading_bins_log2);
  RasterPoint vertices[3];
  for (size_t i = 0; i < 3; ++i) vertices[i] = frame_->VertexAt(primitive, corners.vertices[i], t);
  return Shade(*frame_, triangle.id, at, PixelFootprint(vertices, at));
}

void CellFilm::Write(const Pass& pass, int x, int y, const TileRect& rect, std::span<float> rgba,
                     RenderStats& stats) {
  struct Share {
    uint32_t count;
    V3f color;
  };
  std::vector<Share> shares;
  for (int row = pass.y0; row < pass.y1; ++row) {
    for (int column = pass.x0; column < pass.x1; ++column) {
      const size_t pixel = PixelOf(column, row);
      std::array<double, 4> sum = total_[pixel];
      shares.clear();
      for (uint32_t i = varying_ ? first_pair_[pixel] : 0; i != 0; i = pairs_[i].next) {
        shares.push_back({pairs_[i].count, ShadePair(pairs_[i])});
      }
      // In an order that does not depend on how triangles are numbered.
      std::sort(shares.begin(), shares.end(), [](const Share& a, const Share& b) {
        return std::tie(a.count, a.color.x, a.color.y, a.color.z) <
               std::tie(b.count, b.color.x, b.color.y, b.color.z);
      });
      for (const Share& share : shares) {
        sum[0] += share.count * double(share.color.x);
        sum[1] += share.count * double(share.color.y);
        sum[2] += share.count * double(share.color.z);
      }
      stats.pairs += int64_t(shares.size());
      const size_t to = size_t(y + row - rect.y) * size_t(rect.width) + size_t(x + column - rect.x);
      for (size_t i = 0; i < 4; ++i) rgba[4 * to + i] = float(sum[i] / pass.spp);
    }
  }
}

}  // namespace shutterline::engine
