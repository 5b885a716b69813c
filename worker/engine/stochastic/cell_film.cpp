#include "worker/engine/stochastic/cell_film.h"

#include <algorithm>
#include <tuple>

#include "worker/engine/shading/footprint.h"

namespace shutterline::engine {
namespace {

/// A pixel with more pairs than this finds them through a hash table.
constexpr uint32_t kLongestSearch = 24;

}  // namespace

void CellFilm::Reset(const Shader& shader, const CellTriangles& cell) {
  constexpr size_t kPixels = size_t{kCellSize} * kCellSize;
  shader_ = &shader;
  cell_ = &cell;
  varying_ = std::any_of(cell.triangles.begin(), cell.triangles.end(),
                         [](const CellTriangle& t) { return t.needs_position; });
  colors_.assign(cell.triangles.size() + 1, Rgba{0, 0, 0, -1});
  colors_[0] = Rgba{};
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
  if (color[3] < 0) {
    const V3f radiance = shader_->Shade(cell_->triangles[seen - 1].id, Barycentric{}, Footprint{});
    color = Rgba{radiance.x, radiance.y, radiance.z, 1};
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
  for (size_t i = 0; i < group_.size(); ++i) {
    for (size_t channel = 0; channel < 4; ++channel) total_[i][channel] += double(group_[i][channel]);
    group_[i] = Rgba{};
  }
}

template <int kPixels>
void CellFilm::AddBlock(const uint32_t* seen, int samples, Rgba* sums) {
  Rgba sum[kPixels];
  for (int i = 0; i < kPixels; ++i) sum[i] = sums[i];
  // What lies beyond the last stratum sees the background, which is nothing.
  for (int s = 0; s < samples; s += kPixels) {
    for (int i = 0; i < kPixels; ++i) sum[i] += ColorOf(seen[s + i]);
  }
  for (int i = 0; i < kPixels; ++i) sums[i] = sum[i];
}

void CellFilm::AddConstant(const Pass& pass, const PassBuffers& buffers) {
  const PassShape& shape = pass.shape;
  const int log2 = shape.block_log2, samples = shape.vectors() * kVectorSamples;
  for (int y = pass.y0 >> log2; y <= (pass.y1 - 1) >> log2; ++y) {
    for (int x = pass.x0 >> log2; x <= (pass.x1 - 1) >> log2; ++x) {
      const int block = y * shape.blocks_per_side() + x;
      const uint32_t* const seen = buffers.seen.get() + size_t(block) * size_t(samples);
      Rgba* const sums = group_.data() + (size_t(block) << (2 * log2));
      if (log2 == 2) {
        AddBlock<16>(seen, samples, sums);
      } else if (log2 == 1) {
        AddBlock<4>(seen, samples, sums);
      } else {
        AddBlock<1>(seen, samples, sums);
      }
    }
  }
}

void CellFilm::AddVarying(const Pass& pass, const PassBuffers& buffers) {
  const int strata = std::min(pass.shape.strata, pass.spp - pass.first_stratum);
  for (int y = pass.y0; y < pass.y1; ++y) {
    for (int x = pass.x0; x < pass.x1; ++x) {
      const size_t pixel = PixelIndex(pass.shape, x, y);
      Rgba sum = group_[pixel];
      for (int s = 0; s < strata; ++s) {
        const size_t at = SampleIndex(pass.shape, x, y, s);
        const uint32_t what = buffers.seen[at];
        if (what == 0) continue;
        const CellTriangle& triangle = cell_->triangles[what - 1];
        if (!triangle.needs_position) {
          sum += ColorOf(what);
          continue;
        }
        sum += Rgba{0, 0, 0, 1};
        uint32_t bin = 0;
        if (triangle.shading_bins_log2 > 0) {
          const auto bins = uint32_t{1} << triangle.shading_bins_log2;
          const float t = 0.5f * buffers.tau[at] + 0.5f;
          bin = std::min(uint32_t(std::max(t, 0.0f) * float(bins)), bins - 1);
        }
        Pair& pair = PairOf(int(pixel), triangle.id, what - 1, bin);
        ++pair.count;
        pair.b1 += double(buffers.b1[at]);
        pair.b2 += double(buffers.b2[at]);
      }
      group_[pixel] = sum;
    }
  }
}

CellFilm::Pair& CellFilm::PairOf(int pixel, uint32_t id, uint32_t triangle, uint32_t bin) {
  const auto matches = [&](const Pair& p) { return p.id == id && p.bin == bin; };
  uint32_t& latest = latest_pair_[size_t(pixel)];
  if (latest != 0 && matches(pairs_[latest])) return pairs_[latest];
  const std::array<uint32_t, 3> key{uint32_t(pixel), id, bin};
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
    pairs_.push_back({.id = id, .triangle = triangle, .bin = bin, .next = first_pair_[size_t(pixel)]});
    first_pair_[size_t(pixel)] = found;
    if (++count == kLongestSearch + 1) {
      for (uint32_t i = found; i != 0; i = pairs_[i].next) {
        index_[{uint32_t(pixel), pairs_[i].id, pairs_[i].bin}] = i;
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
  const FrameScene& frame = shader_->frame();
  const FrameTriangle& corners = frame.triangles[triangle.id];
  const FramePrimitive& primitive = frame.primitives[corners.primitive];
  // Rounding may leave the triangle.
  Barycentric at;
  at.b1 = std::clamp(pair.b1 / pair.count, 0.0, 1.0);
  at.b2 = std::clamp(pair.b2 / pair.count, 0.0, 1.0 - at.b1);
  const double t = (pair.bin + 0.5) / double(1u << triangle.shading_bins_log2);
  std::array<RasterPoint, 3> vertices;
  for (size_t i = 0; i < 3; ++i) vertices[i] = frame.VertexAt(primitive, corners.vertices[i], t);
  return shader_->Shade(triangle.id, at, PixelFootprint(vertices, at));
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
      const size_t pixel = PixelIndex(pass.shape, column, row);
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
