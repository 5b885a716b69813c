#include "worker/engine/shading/shade.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <utility>

#include "common/base/status_macros.h"
#include "worker/engine/shading/directional_albedo.h"
#include "worker/engine/shading/head_light.h"
#include "worker/engine/shading/reflect.h"
#include "worker/engine/shading/surface.h"
#include "worker/engine/shading/texture_lookup.h"

namespace shutterline::engine {

absl::StatusOr<Shader> Shader::Create(std::shared_ptr<const FrameScene> frame, const RenderSettings& settings,
                                      int threads) {
  SL_ASSIGN_OR_RETURN(Lighting lighting, MakeLighting(*frame, settings));
  std::shared_ptr<const AmbientOcclusion> occlusion;
  const bool is_shown =
      std::find(settings.aovs.begin(), settings.aovs.end(), Aov::kAmbientOcclusion) != settings.aovs.end();
  if (settings.occlusion && (is_shown || (lighting.HasSky() && !lighting.head_light))) {
    SL_ASSIGN_OR_RETURN(AmbientOcclusion made, AmbientOcclusion::Create(frame, *settings.occlusion, threads));
    occlusion = std::make_shared<const AmbientOcclusion>(std::move(made));
  }
  // Made by all threads now, instead of by the first that shades while the others wait.
  const auto is_lit = [](const FramePrimitive& primitive) { return !primitive.material->unlit; };
  if (!lighting.head_light && std::any_of(frame->primitives.begin(), frame->primitives.end(), is_lit)) {
    DirectionalAlbedoTable::Get();
  }
  return Shader(std::move(frame), std::move(lighting), std::move(occlusion));
}

Shader::Shader(std::shared_ptr<const FrameScene> frame, Lighting lighting,
               std::shared_ptr<const AmbientOcclusion> occlusion)
    : frame_(std::move(frame)), lighting_(std::move(lighting)), occlusion_(std::move(occlusion)) {
  materials_.reserve(frame_->primitives.size());
  for (const FramePrimitive& primitive : frame_->primitives) materials_.emplace_back(*frame_, primitive);
}

Shaded Shader::ShadeUnder(const AmbientOcclusion* occlusion, uint32_t triangle, const Barycentric& at,
                          const Footprint& footprint) const {
  const uint32_t number = frame_->triangles[triangle].primitive;
  const FramePrimitive& primitive = frame_->primitives[number];
  if (primitive.material->unlit) return ShadeUnlit(triangle, at, footprint);
  return ShadeLit(occlusion, SurfaceTriangle(*frame_, materials_[number], triangle), at, footprint);
}

Shaded Shader::ShadeUnlit(uint32_t triangle, const Barycentric& at, const Footprint& footprint) const {
  const V4d color = BaseColor(triangle, at, footprint);
  return {.radiance = V3f(V3d(color.x, color.y, color.z)), .openness = 1};
}

Shaded Shader::ShadeLit(const AmbientOcclusion* occlusion, const SurfaceTriangle& triangle,
                        const Barycentric& at, const Footprint& footprint) const {
  Surface surface = SurfaceAt(*frame_, triangle, at, footprint);
  const double openness = occlusion == nullptr ? 1 : occlusion->At(triangle.number, at.b1, at.b2);
  surface.occlusion *= openness;
  const V3d reflected =
      lighting_.head_light ? ReflectHeadLight(surface) : Reflect(frame_->view, lighting_, surface);
  return {.radiance = V3f(reflected + surface.emission), .openness = float(openness)};
}

Surface Shader::SurfaceOf(uint32_t triangle, const Barycentric& at, const Footprint& footprint) const {
  return SurfaceAt(*frame_, TriangleOf(triangle), at, footprint);
}

bool Shader::IsConstant(const FramePrimitive& primitive) const {
  return primitive.material->unlit && (primitive.uniform_colors || primitive.source->colors.empty()) &&
         !IsTextured(*frame_, primitive);
}

V4d Shader::BaseColor(uint32_t triangle, const Barycentric& at, const Footprint& footprint) const {
  const FrameTriangle& corners = frame_->triangles[triangle];
  return BaseColorAt(frame_->primitives[corners.primitive], materials_[corners.primitive], corners, at,
                     footprint);
}

double Shader::Alpha(uint32_t triangle, const Barycentric& at, const Footprint& footprint) const {
  return BaseColor(triangle, at, footprint).w;
}

bool Shader::IsGlossy(const Material& material) const {
  constexpr float kRoughEnough = 0.45f;
  if (material.unlit || lighting_.head_light) return false;
  return material.roughness_factor < kRoughEnough || !lighting_.lights.empty();  // Shadows have edges.
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

absl::Status Shader::CheckOpaque(absl::string_view method) const {
  const std::vector<PrimitiveTraits> traits = Traits();
  for (size_t i = 0; i < traits.size(); ++i) {
    if (!traits[i].layer) continue;
    const Material& material = *frame_->primitives[i].material;
    return absl::UnimplementedError(absl::StrCat(
        method, ": material \"", material.name, "\" has alpha mode ",
        material.alpha_mode == AlphaMode::kMask ? "MASK" : "BLEND",
        ", which it does not know; integrator line with resolver slice, and integrator reference, do"));
  }
  return absl::OkStatus();
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
