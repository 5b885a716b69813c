#include "worker/engine/render/tile_texels.h"

#include <optional>

namespace shutterline::engine {

uint32_t TileTexels::Prepare(uint32_t triangle) {
  const auto [place, is_new] = number_of_.try_emplace(triangle, uint32_t(triangles_.size()));
  if (is_new) triangles_.push_back(shader_.TriangleOf(triangle));
  if (near_.empty() && shader_.HasCache()) near_.resize(size_t{1} << kNearLog2);
  return place->second;
}

V3f TileTexels::At(uint32_t prepared, double b1, double b2) {
  const TexelShader::Triangle& triangle = triangles_[prepared];
  const std::optional<Texel> texel = shader_.TexelOf(triangle, {b1, b2});
  if (!texel) return shader_.ShadePoint(triangle, {b1, b2}).radiance;
  const TexelKey key = texel->KeyOf(triangle.number);
  if (near_.empty()) return shader_.ShadeTexel(triangle, *texel, key, stats_).radiance;
  const uint64_t hash = (key.low ^ uint64_t{key.high} << 22) * 0x9e3779b97f4a7c15u;
  Near& near = near_[hash >> (64 - kNearLog2)];
  if (near.filled && near.key == key) {
    ++stats_.shading_requests;
    ++stats_.shading_hits;
    return near.radiance;
  }
  near = {.key = key, .filled = true, .radiance = shader_.ShadeTexel(triangle, *texel, key, stats_).radiance};
  return near.radiance;
}

}  // namespace shutterline::engine
