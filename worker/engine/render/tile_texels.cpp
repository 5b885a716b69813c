#include "worker/engine/render/tile_texels.h"

#include <algorithm>
#include <bit>
#include <new>
#include <utility>

#include "common/math/tolerance.h"

namespace shutterline::engine {
namespace {

/// Of a number of cells.
int LevelOf(double cells) {
  return int(std::bit_cast<uint64_t>(cells) >> 52) - 1023;
}

/// Neighbours in a row of a triangle's texels are neighbours among what is near, and a window of them has
/// places of its own.
constexpr int kWindowLog2 = 6;
constexpr uint32_t kNearMask = (uint32_t{1} << TexelDesk::kNearLog2) - 1;

uint32_t CornerOf(uint32_t triangle, int level1, int level2) {
  const auto levels = uint32_t(level1 << 5 | level2);
  return ((triangle + (levels << 20)) * 0x9e3779b1u) >> (32 - TexelDesk::kNearLog2);
}

uint32_t PlaceOf(uint32_t corner, uint32_t i, uint32_t j) {
  return (corner + i + (j << kWindowLog2)) & kNearMask;
}

}  // namespace

std::unique_ptr<TexelDesk> TexelDesks::Take() {
  const std::lock_guard lock(mutex_);
  if (free_.empty()) return std::make_unique<TexelDesk>();
  std::unique_ptr<TexelDesk> desk = std::move(free_.back());
  free_.pop_back();
  return desk;
}

void TexelDesks::Give(std::unique_ptr<TexelDesk> desk) {
  const std::lock_guard lock(mutex_);
  try {
    free_.push_back(std::move(desk));
  } catch (const std::bad_alloc&) {  // The next tile makes itself another.
  }
}

TileTexels::TileTexels(const TexelShader& shader, TexelDesks& desks, RenderStats& stats)
    : shader_(shader), desks_(desks), stats_(stats), desk_(desks.Take()) {
  desk_->number_of.clear();
  desk_->triangles.clear();
  desk_->even.clear();
  desk_->batch.Clear();  // A tile that ran out of memory leaves points that it will not ask for.
}

const TexelShader::Triangle& TileTexels::Known(uint32_t triangle) {
  if (!knows_last_ || last_.number != triangle) last_ = shader_.TriangleOf(triangle);
  knows_last_ = true;
  return last_;
}

std::optional<V3f> TileTexels::ColorOfAll(uint32_t triangle) {
  const TexelShader::Triangle& known = Known(triangle);
  if (!known.levels.IsOneTexel()) return std::nullopt;
  return RadianceOf(known, Texel{}, Texel{}.KeyOf(triangle));
}

uint32_t TileTexels::Prepare(uint32_t triangle) {
  const auto [place, is_new] = desk_->number_of.try_emplace(triangle, uint32_t(desk_->triangles.size()));
  if (!is_new) return place->second;
  const TexelShader::Triangle& known = Known(triangle);
  desk_->triangles.push_back(known);
  TexelDesk::Even& even = desk_->even.emplace_back();
  if (!known.levels.is_uniform()) return place->second;
  const Texel first{.level1 = LevelOf(known.levels.columns()), .level2 = LevelOf(known.levels.rows())};
  even = {.is_even = true,
          .level2 = first.level2,
          .key_low = first.KeyOf(triangle).low,
          .corner = CornerOf(triangle, first.level1, first.level2)};
  return place->second;
}

V3f TileTexels::At(uint32_t prepared, double b1, double b2) {
  const TexelShader::Triangle& triangle = desk_->triangles[prepared];
  const std::optional<Texel> texel = shader_.TexelOf(triangle, {b1, b2});
  if (!texel) return shader_.ShadePoint(triangle, {b1, b2}).radiance;
  return RadianceOf(triangle, *texel, texel->KeyOf(triangle.number));
}

V3f TileTexels::RadianceOf(const TexelShader::Triangle& triangle, const Texel& texel, const TexelKey& key) {
  if (!shader_.HasCache()) return shader_.ShadeTexel(triangle, texel, key, stats_).radiance;
  if (desk_->near.empty()) desk_->near.resize(size_t{1} << TexelDesk::kNearLog2);
  TexelDesk::Near& near = NearOf(triangle.number, texel);
  if (near.key == key) {
    ++stats_.shading_requests;
    ++stats_.shading_hits;
    return near.radiance;
  }
  near = {.key = key, .radiance = shader_.ShadeTexel(triangle, texel, key, stats_).radiance};
  return near.radiance;
}

TexelDesk::Near& TileTexels::NearOf(uint32_t triangle, const Texel& texel) {
  return desk_->near[PlaceOf(CornerOf(triangle, texel.level1, texel.level2), texel.i, texel.j)];
}

void TileTexels::AddAlong(uint32_t prepared, const LinePosition& position, const Piece& piece, double weight,
                          Color* sums_of_line) {
  TexelBatch& batch = desk_->batch;
  const TexelLevelsOfTriangle& levels = desk_->triangles[prepared].levels;
  const int part_bits = kSubpixelBits - piece.parts_log2;
  for (int32_t at = piece.begin; at < piece.end;) {
    if (batch.count == TexelBatch::kMost) Finish();
    const auto next = int32_t(std::min<int64_t>(piece.end, ((int64_t{at} >> part_bits) + 1) << part_bits));
    // The colour in the middle of the part stands for its mean.
    const double l = (double(at) + double(next)) * (0.5 / kSubpixelsPerPixel);
    desk_->wanted[batch.count] = {prepared, weight * double(next - at), &sums_of_line[at >> kSubpixelBits]};
    batch.Add(position.at[0] + position.per_pixel[0] * l, position.at[1] + position.per_pixel[1] * l,
              position.at[2] + position.per_pixel[2] * l, levels);
    at = next;
  }
}

void TileTexels::SpreadAlong(uint32_t prepared, const LinePosition& position, const Piece& piece,
                             double weight, const LineSpread& spread, Color* sums_of_line) {
  TexelBatch& batch = desk_->batch;
  const TexelLevelsOfTriangle& levels = desk_->triangles[prepared].levels;
  const int part_bits = kSubpixelBits - piece.parts_log2;
  desk_->spreads.resize(TexelBatch::kMost);
  const auto taps = size_t(spread.taps());
  for (int32_t at = piece.begin; at < piece.end;) {
    if (batch.count == TexelBatch::kMost) Finish();
    taps_ = taps;
    const auto next = int32_t(std::min<int64_t>(piece.end, ((int64_t{at} >> part_bits) + 1) << part_bits));
    const double l = (double(at) + double(next)) * (0.5 / kSubpixelsPerPixel);
    LineSpread::Weights& weights = desk_->spreads[batch.count];
    spread.Along(at, next, weights);
    for (size_t k = 0; k < taps; ++k) weights[k] *= weight;
    desk_->wanted[batch.count] = {prepared, weight, &sums_of_line[size_t(at >> kSubpixelBits) * taps]};
    batch.Add(position.at[0] + position.per_pixel[0] * l, position.at[1] + position.per_pixel[1] * l,
              position.at[2] + position.per_pixel[2] * l, levels);
    at = next;
  }
}

Texel TileTexels::TexelOf(size_t k) const {
  const TexelBatch& batch = desk_->batch;
  return {.level1 = LevelOf(batch.columns[k]),
          .level2 = LevelOf(batch.rows[k]),
          .i = uint32_t(batch.i[k]),
          .j = uint32_t(batch.j[k])};
}

void TileTexels::LookNear(size_t k, const TexelKey& key, uint32_t place) {
  const TexelDesk::Near& near = desk_->near[place];
  if (near.key == key) {
    desk_->radiance[k] = near.radiance;
    return;
  }
  shader_.Prefetch(key);
  desk_->keys[k] = key;
  desk_->missed[missed_++] = uint32_t(k);
}

void TileTexels::LookNear() {
  const TexelBatch& batch = desk_->batch;
  size_t without = 0;
  for (size_t k = 0; k < batch.count; ++k) {
    const uint32_t prepared = desk_->wanted[k].prepared;
    const TexelDesk::Even& even = desk_->even[prepared];
    if (even.is_even) {
      const uint32_t i = uint32_t(batch.i[k]), j = uint32_t(batch.j[k]);
      LookNear(k, Texel::KeyWith(even.key_low, even.level2, i, j), PlaceOf(even.corner, i, j));
      continue;
    }
    const TexelShader::Triangle& triangle = desk_->triangles[prepared];
    if (!(batch.columns[k] > 0)) {
      desk_->radiance[k] = shader_.ShadePoint(triangle, {batch.b1[k], batch.b2[k]}).radiance;
      ++without;
      continue;
    }
    const Texel texel = TexelOf(k);
    LookNear(k, texel.KeyOf(triangle.number),
             PlaceOf(CornerOf(triangle.number, texel.level1, texel.level2), texel.i, texel.j));
  }
  const auto hits = int64_t(batch.count - without - missed_);
  stats_.shading_requests += hits;
  stats_.shading_hits += hits;
}

V3f TileTexels::ShadeWanted(size_t k) {
  const TexelBatch& batch = desk_->batch;
  const TexelShader::Triangle& triangle = desk_->triangles[desk_->wanted[k].prepared];
  if (!(batch.columns[k] > 0)) return shader_.ShadePoint(triangle, {batch.b1[k], batch.b2[k]}).radiance;
  const Texel texel = TexelOf(k);
  return shader_.ShadeTexel(triangle, texel, texel.KeyOf(triangle.number), stats_).radiance;
}

void TileTexels::Finish() {
  TexelBatch& batch = desk_->batch;
  if (batch.count == 0) return;
  FindTexels(batch);
  if (shader_.HasCache()) {
    if (desk_->near.empty()) desk_->near.resize(size_t{1} << TexelDesk::kNearLog2);
    missed_ = 0;
    LookNear();
    // What is not near is asked for together, when memory has had time.
    for (size_t m = 0; m < missed_; ++m) {
      const size_t k = desk_->missed[m];
      desk_->radiance[k] =
          RadianceOf(desk_->triangles[desk_->wanted[k].prepared], TexelOf(k), desk_->keys[k]);
    }
  } else {
    for (size_t k = 0; k < batch.count; ++k) desk_->radiance[k] = ShadeWanted(k);
  }
  AddWanted();
  batch.Clear();
  taps_ = 0;
}

void TileTexels::AddWanted() {
  const size_t count = desk_->batch.count;
  if (taps_ != 0) {
    for (size_t k = 0; k < count; ++k) {
      const V3f& radiance = desk_->radiance[k];
      for (size_t tap = 0; tap < taps_; ++tap) {
        Color& sum = desk_->wanted[k].sum[tap];
        const double weight = desk_->spreads[k][tap];
        sum[0] += weight * double(radiance.x);
        sum[1] += weight * double(radiance.y);
        sum[2] += weight * double(radiance.z);
        sum[3] += weight;
      }
    }
    return;
  }
  for (size_t k = 0; k < count; ++k) {
    const TexelDesk::Wanted& wanted = desk_->wanted[k];
    const V3f& radiance = desk_->radiance[k];
    Color& sum = *wanted.sum;
    sum[0] += wanted.weight * double(radiance.x);
    sum[1] += wanted.weight * double(radiance.y);
    sum[2] += wanted.weight * double(radiance.z);
    sum[3] += wanted.weight;
  }
}

}  // namespace shutterline::engine
