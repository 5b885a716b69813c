#include "worker/engine/shading/shade.h"

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
  const V3d reflected = lighting_.head_light ? ReflectHeadLight(surface)
                                             : Reflect(frame_->view, lighting_, surface);
  return V3f(reflected + surface.emission);
}

bool Shader::IsConstant(const FramePrimitive& primitive) const {
  return primitive.material->unlit && (primitive.uniform_colors || primitive.source->colors.empty()) &&
         !IsTextured(*frame_, primitive);
}

std::vector<PrimitiveTraits> Shader::Traits() const {
  std::vector<PrimitiveTraits> traits;
  traits.reserve(frame_->primitives.size());
  for (const FramePrimitive& primitive : frame_->primitives) {
    traits.push_back({.cull_back = !primitive.material->double_sided,
                      .needs_position = !IsConstant(primitive),
                      .textured = IsTextured(*frame_, primitive)});
  }
  return traits;
}

}  // namespace shutterline::engine
