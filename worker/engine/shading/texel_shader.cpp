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
    textured_.push_back(IsTextured(shader.frame(), primitive));
    // Without light and textures a point's colour is sooner computed than looked up, and a texel's is less
    // exact.
    const bool is_cheap = primitive.material->unlit && !textured_.back();
    const bool is_shared =
        sharing == Sharing::kMoving ? primitive.degree > 0 && !is_cheap : shader.IsDear(*primitive.material);
    has_texels_.push_back(settings.shading_rate || is_shared);
  }
}

TexelShader::Triangle TexelShader::TriangleOf(uint32_t triangle) const {
  const std::array<RasterPoint, 3> corners = CornersAt(shader_.frame(), triangle, kMidShutter);
  return {.number = triangle, .corners = corners, .levels = TexelLevelsOfTriangle(corners, rate_)};
}

std::optional<Texel> TexelShader::TexelOf(const Triangle& triangle, const Barycentric& at) const {
  const std::optional<TexelLevels> levels = triangle.levels.At(at);
  return levels ? std::optional(TexelAt(at, *levels)) : std::nullopt;
}

Shaded TexelShader::Shade(uint32_t triangle, const Barycentric& at, double t, RenderStats& stats) const {
  if (HasTexels(triangle)) {
    const Triangle on = TriangleOf(triangle);
    const std::optional<Texel> texel = TexelOf(on, at);
    return texel ? ShadeTexel(on, *texel, texel->KeyOf(triangle), stats) : ShadePoint(on, at);
  }
  const FrameScene& frame = shader_.frame();
  const bool textured = textured_[frame.triangles[triangle].primitive];
  return shader_.ShadeFully(triangle, at, textured ? PixelFootprintAt(frame, triangle, at, t) : Footprint{});
}

Shaded TexelShader::Shade(uint32_t triangle, const Barycentric& at, double t, Lately& lately,
                          RenderStats& stats) const {
  if (HasTexels(triangle)) return Shade(triangle, at, t, stats);
  const SurfaceTriangle& on = lately.Of(triangle);
  if (on.primitive->degree == 0) return ShadeStill(on, at);
  Footprint footprint;
  if (IsTexturedOn(shader_.frame().triangles[triangle].primitive))
    footprint = PixelFootprintAt(shader_.frame(), triangle, at, t);
  return shader_.ShadeFully(on, at, footprint);
}

Shaded TexelShader::ShadeStill(const SurfaceTriangle& triangle, const Barycentric& at) const {
  const Footprint footprint = IsTexturedOn(shader_.frame().triangles[triangle.number].primitive)
                                  ? PixelFootprint(triangle.raster, at)
                                  : Footprint{};
  return shader_.ShadeFully(triangle, at, footprint);
}

Shaded TexelShader::ShadePoint(const Triangle& triangle, const Barycentric& at) const {
  return shader_.ShadeFully(triangle.number, at, PixelFootprint(triangle.corners, at));
}

Shaded TexelShader::ShadeTexel(const Triangle& triangle, const Texel& texel, const TexelKey& key,
                               RenderStats& stats) const {
  ++stats.shading_requests;
  Shaded shaded;
  if (cache_ && cache_.Find(key, shaded)) {
    ++stats.shading_hits;
    return shaded;
  }
  const Barycentric centre = texel.Centre();
  Footprint footprint = PixelFootprint(triangle.corners, centre);
  footprint.db1_dx /= rate_;
  footprint.db1_dy /= rate_;
  footprint.db2_dx /= rate_;
  footprint.db2_dy /= rate_;
  shaded = shader_.ShadeFully(triangle.number, centre, footprint);
  if (!cache_) return shaded;
  const ShadingCache::Outcome outcome = cache_.Store(key, shaded);
  if (outcome == ShadingCache::Outcome::kDuplicate) ++stats.duplicate_shadings;
  if (outcome == ShadingCache::Outcome::kFull) ++stats.cache_overflows;
  if (propagates_) Propagate(triangle.number, texel, shaded);
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
