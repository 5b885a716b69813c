#include "worker/engine/shading/texel_shader.h"

#include <optional>
#include <utility>

#include "worker/engine/shading/footprint.h"

namespace shutterline::engine {
namespace {

constexpr double kMidShutter = 0.5;

}  // namespace

TexelShader::TexelShader(const Shader& shader, const RenderSettings& settings,
                         std::shared_ptr<ShadingCache> cache, Sharing sharing)
    : shader_(shader),
      rate_(settings.shading_rate.value_or(1)),
      propagates_(settings.cache_propagate),
      cache_(std::move(cache)) {
  for (const FramePrimitive& primitive : shader.frame().primitives) {
    const bool is_dear = shader.IsDear(*primitive.material);
    const bool is_shared = sharing == Sharing::kMovingAndDear && primitive.degree > 0;
    has_texels_.push_back(settings.shading_rate || is_shared || is_dear);
    textured_.push_back(IsTextured(shader.frame(), primitive));
  }
}

TexelShader::Corners TexelShader::CornersOf(uint32_t triangle) const {
  const FrameScene& frame = shader_.frame();
  const FrameTriangle& source = frame.triangles[triangle];
  Corners corners;
  for (size_t k = 0; k < 3; ++k) {
    corners[k] = frame.VertexAt(frame.primitives[source.primitive], source.vertices[k], kMidShutter);
  }
  return corners;
}

Shaded TexelShader::Shade(uint32_t triangle, const Barycentric& at, double t, RenderStats& stats) const {
  if (HasTexels(triangle)) return ShadeOnTexels(triangle, CornersOf(triangle), at, stats);
  const FrameScene& frame = shader_.frame();
  const bool textured = textured_[frame.triangles[triangle].primitive];
  return shader_.ShadeFully(triangle, at, textured ? PixelFootprintAt(frame, triangle, at, t) : Footprint{});
}

Shaded TexelShader::ShadeOnTexels(uint32_t triangle, const Corners& corners, const Barycentric& at,
                                  RenderStats& stats) const {
  const Footprint pixel = PixelFootprint(corners, at);
  const std::optional<Texel> texel = TexelAt(at, pixel, rate_);
  if (texel) return ShadeTexel(triangle, corners, *texel, stats);
  // Behind the camera at mid-shutter: nobody knows how large a pixel is there.
  return shader_.ShadeFully(triangle, at, pixel);
}

Shaded TexelShader::ShadeTexel(uint32_t triangle, const Corners& corners, const Texel& texel,
                               RenderStats& stats) const {
  const TexelKey key = texel.KeyOf(triangle);
  ++stats.shading_requests;
  Shaded shaded;
  if (cache_ && cache_.Find(key, shaded)) {
    ++stats.shading_hits;
    return shaded;
  }
  const Barycentric centre = texel.Centre();
  Footprint footprint = PixelFootprint(corners, centre);
  footprint.db1_dx /= rate_;
  footprint.db1_dy /= rate_;
  footprint.db2_dx /= rate_;
  footprint.db2_dy /= rate_;
  shaded = shader_.ShadeFully(triangle, centre, footprint);
  if (!cache_) return shaded;
  const ShadingCache::Outcome outcome = cache_.Store(key, shaded);
  if (outcome == ShadingCache::Outcome::kDuplicate) ++stats.duplicate_shadings;
  if (outcome == ShadingCache::Outcome::kFull) ++stats.cache_overflows;
  if (propagates_) Propagate(triangle, texel, shaded);
  return shaded;
}

void TexelShader::Propagate(uint32_t triangle, Texel texel, const Shaded& shaded) const {
  // Coarser texels that nobody has asked for yet take it over.
  while (!texel.IsTop()) {
    texel = texel.Parent();
    if (cache_.Store(texel.KeyOf(triangle), shaded) != ShadingCache::Outcome::kStored) return;
  }
}

}  // namespace shutterline::engine
