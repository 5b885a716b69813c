#include "worker/engine/shading/texel_shader.h"

#include <optional>
#include <utility>

#include "worker/engine/shading/footprint.h"

namespace shutterline::engine {
namespace {

constexpr double kMidShutter = 0.5;

}  // namespace

TexelShader::TexelShader(const Shader& shader, const RenderSettings& settings,
                         std::shared_ptr<ShadingCache> cache)
    : shader_(shader),
      rate_(settings.shading_rate),
      propagates_(settings.cache_propagate),
      cache_(std::move(cache)) {
  for (const FramePrimitive& primitive : shader.frame().primitives) {
    const bool is_dear = settings.occlusion && !primitive.material->unlit;
    uses_texels_.push_back(primitive.degree > 0 || is_dear);
    textured_.push_back(IsTextured(shader.frame(), primitive));
  }
}

Shaded TexelShader::Shade(uint32_t triangle, const Barycentric& at, double t, RenderStats& stats) const {
  const FrameScene& frame = shader_.frame();
  const uint32_t primitive = frame.triangles[triangle].primitive;
  if (uses_texels_[primitive]) {
    const std::optional<Texel> texel = TexelAt(at, PixelFootprintAt(frame, triangle, at, kMidShutter), rate_);
    if (texel) return ShadeTexel(triangle, *texel, stats);
  }
  const Footprint footprint = textured_[primitive] ? PixelFootprintAt(frame, triangle, at, t) : Footprint{};
  return shader_.ShadeFully(triangle, at, footprint);
}

Shaded TexelShader::ShadeTexel(uint32_t triangle, const Texel& texel, RenderStats& stats) const {
  const uint64_t key = texel.Key(triangle);
  ++stats.shading_requests;
  Shaded shaded;
  if (cache_ && cache_.Find(key, shaded)) {
    ++stats.shading_hits;
    return shaded;
  }
  const Barycentric centre = texel.Centre();
  Footprint footprint = PixelFootprintAt(shader_.frame(), triangle, centre, kMidShutter);
  footprint.db1_dx /= rate_;
  footprint.db1_dy /= rate_;
  footprint.db2_dx /= rate_;
  footprint.db2_dy /= rate_;
  shaded = shader_.ShadeFully(triangle, centre, footprint);
  if (!cache_) return shaded;
  const auto count = [&](ShadingCache::Outcome outcome) {
    if (outcome == ShadingCache::Outcome::kDuplicate) ++stats.duplicate_shadings;
    if (outcome == ShadingCache::Outcome::kFull) ++stats.cache_overflows;
  };
  count(cache_.Store(key, shaded));
  if (!propagates_) return shaded;
  // Coarser texels that nobody has asked for yet take it over.
  for (Texel above = texel; !above.IsTop();) {
    above = above.Parent();
    if (cache_.Store(above.Key(triangle), shaded) != ShadingCache::Outcome::kStored) break;
  }
  return shaded;
}

}  // namespace shutterline::engine
