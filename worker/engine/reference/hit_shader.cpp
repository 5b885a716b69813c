#include "worker/engine/reference/hit_shader.h"

#include <algorithm>
#include <utility>

#include "worker/engine/shading/footprint.h"

namespace shutterline::engine {
namespace {

/// Embree's coordinates may leave the triangle by a rounding.
Barycentric Inside(double b1, double b2) {
  Barycentric at;
  at.b1 = std::clamp(b1, 0.0, 1.0);
  at.b2 = std::clamp(b2, 0.0, 1.0 - at.b1);
  return at;
}

}  // namespace

HitShader::HitShader(Shader shader, const RenderSettings& settings, std::shared_ptr<ShadingCache> cache)
    : shader_(std::move(shader)),
      texels_(shader_, settings, std::move(cache), TexelShader::Sharing::kDear),
      traits_(shader_.Traits()) {
  const FrameScene& scene = shader_.frame();
  for (const FramePrimitive& primitive : scene.primitives) {
    is_constant_.push_back(shader_.IsConstant(primitive));
    if (!is_constant_.back()) continue;
    constant_shades_.resize(scene.triangles.size());
    for (uint32_t i = 0; i < primitive.triangle_count; ++i) {
      const uint32_t triangle = primitive.first_triangle + i;
      constant_shades_[triangle] = shader_.Shade(triangle, Barycentric{}, Footprint{});
    }
  }
}

V3f HitShader::Radiance(uint32_t triangle, double b1, double b2, double t, RenderStats& stats) const {
  if (is_constant_[frame().triangles[triangle].primitive]) return constant_shades_[triangle];
  return texels_.Shade(triangle, Inside(b1, b2), t, stats).radiance;
}

double HitShader::Alpha(uint32_t triangle, double b1, double b2, double t) const {
  const PrimitiveTraits& traits = traits_[frame().triangles[triangle].primitive];
  if (!traits.layer) return 1;
  double alpha = double(traits.layer_alpha);
  if (alpha < 0) {
    const Barycentric at = Inside(b1, b2);
    alpha = shader_.Alpha(triangle, at, PixelFootprintAt(frame(), triangle, at, t));
  }
  if (traits.alpha_cutoff > 0) return alpha >= double(traits.alpha_cutoff) ? 1 : 0;
  return std::clamp(alpha, 0.0, 1.0);
}

}  // namespace shutterline::engine
