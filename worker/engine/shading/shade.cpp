#include "worker/engine/shading/shade.h"

#include <algorithm>
#include <utility>

#include "worker/engine/shading/head_light.h"
#include "worker/engine/shading/reflect.h"
#include "worker/engine/shading/surface.h"

namespace shutterline::engine {

Shader::Shader(std::shared_ptr<const FrameScene> frame, const RenderSettings& settings)
    : frame_(std::move(frame)), lighting_(MakeLighting(*frame_, settings)) {}

V3f Shader::Shade(uint32_t triangle, const Barycentric& at, const Footprint& footprint) const {
  const FrameTriangle& corners = frame_->triangles[triangle];
  const FramePrimitive& primitive = frame_->primitives[corners.primitive];
  if (primitive.material->unlit) {
    const V4d color = BaseColorAt(*frame_, primitive, corners, at, footprint);
    return V3f(V3d(color.x, color.y, color.z));
  }
  const Surface surface = SurfaceAt(*frame_, primitive, corners, triangle, at, footprint);
  const V3d reflected =
      lighting_.head_light ? ReflectHeadLight(surface) : Reflect(frame_->view, lighting_, surface);
  return V3f(reflected + surface.emission);
}

bool Shader::IsConstant(const FramePrimitive& primitive) const {
  return primitive.material->unlit && (primitive.uniform_colors || primitive.source->colors.empty()) &&
         !IsTextured(*frame_, primitive);
}

double Shader::Alpha(uint32_t triangle, const Barycentric& at, const Footprint& footprint) const {
  const FrameTriangle& corners = frame_->triangles[triangle];
  return BaseColorAt(*frame_, frame_->primitives[corners.primitive], corners, at, footprint).w;
}

bool Shader::IsGlossy(const Material& material) const {
  constexpr float kRoughEnough = 0.45f;
  return !material.unlit && !lighting_.head_light && material.roughness_factor < kRoughEnough;
}

std::vector<PrimitiveTraits> Shader::Traits() const {
  std::vector<PrimitiveTraits> traits;
  traits.reserve(frame_->primitives.size());
  for (const FramePrimitive& primitive : frame_->primitives) {
    PrimitiveTraits made{.cull_back = !primitive.material->double_sided,
                         .needs_position = !IsConstant(primitive),
                         .textured = IsTextured(*frame_, primitive),
                         .glossy = IsGlossy(*primitive.material)};
    MakeLayer(primitive, made);
    traits.push_back(made);
  }
  return traits;
}

void Shader::MakeLayer(const FramePrimitive& primitive, PrimitiveTraits& traits) const {
  const Material& material = *primitive.material;
  if (material.alpha_mode == AlphaMode::kOpaque) return;
  const bool cut = material.alpha_mode == AlphaMode::kMask;
  if (cut && !(material.alpha_cutoff > 0)) return;
  traits.alpha_cutoff = cut ? material.alpha_cutoff : 0;
  const std::vector<V4f>& colors = primitive.source->colors;
  const bool varies =
      IsUsed(*frame_, *primitive.source, material.base_color_texture, TextureEncoding::kSrgb) ||
      std::any_of(colors.begin(), colors.end(), [&](const V4f& c) { return c.w != colors[0].w; });
  if (varies) {
    traits.layer = true;
    traits.layer_alpha = -1;
    traits.needs_position = true;
    return;
  }
  const float alpha = material.base_color_factor.w * (colors.empty() ? 1 : colors[0].w);
  if (alpha >= (cut ? material.alpha_cutoff : 1)) return;
  traits.layer = true;
  traits.layer_alpha = cut ? 0 : std::max(alpha, 0.0f);
}

}  // namespace shutterline::engine
