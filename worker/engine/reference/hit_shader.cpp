#include "worker/engine/reference/hit_shader.h"

#include <algorithm>
#include <utility>

#include "worker/engine/shading/footprint.h"

namespace shutterline::engine {

HitShader::HitShader(std::shared_ptr<const FrameScene> frame, const RenderSettings& settings)
    : shader_(std::move(frame), settings) {
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

V3f HitShader::Radiance(uint32_t triangle, double b1, double b2, double t) const {
  const FrameScene& scene = shader_.frame();
  const FrameTriangle& corners = scene.triangles[triangle];
  if (is_constant_[corners.primitive]) return constant_shades_[triangle];
  // Embree's coordinates may leave the triangle by a rounding.
  Barycentric at;
  at.b1 = std::clamp(b1, 0.0, 1.0);
  at.b2 = std::clamp(b2, 0.0, 1.0 - at.b1);
  const FramePrimitive& primitive = scene.primitives[corners.primitive];
  RasterPoint vertices[3];
  for (int i = 0; i < 3; ++i) vertices[i] = scene.VertexAt(primitive, corners.vertices[i], t);
  return shader_.Shade(triangle, at, PixelFootprint(vertices, at));
}

}  // namespace shutterline::engine
