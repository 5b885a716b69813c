#include "worker/engine/shading/shade.h"

#include <utility>

#include "worker/engine/shading/head_light.h"
#include "worker/engine/shading/reflect.h"
#include "worker/engine/shading/surface.h"

namespace shutterline::engine {

Shader::Shader(std::shared_ptr<const FrameScene> frame, const RenderSettings& settings)
    : frame_(std::move(frame)), lighting_(MakeLighting(*frame_, settings)) {}

<<<<<<< HEAD
V3f Shader::Shade(uint32_t triangle, const Barycentric& at, const Footprint& footprint) const {
  const FrameTriangle& corners = frame_->triangles[triangle];
  const FramePrimitive& primitive = frame_->primitives[corners.primitive];
  if (primitive.material->unlit) {
    const V4d color = BaseColorAt(*frame_, primitive, corners, at, footprint);
    return V3f(V3d(color.x, color.y, color.z));
=======
/// A point of a triangle, with what interpolation needs.
struct ShadingPoint {
  const FrameScene& frame;
  const FramePrimitive& primitive;
  const FrameTriangle& triangle;
  std::array<double, 3> weights;  ///< Barycentric, of the triangle's three corners.
  const Footprint& footprint;

  size_t Local(int corner) const { return triangle.vertices[size_t(corner)] - primitive.first_vertex; }
};

V3d VertexColor(const ShadingPoint& point) {
  const std::vector<V4f>& colors = point.primitive.source->colors;
  if (colors.empty()) return V3d(1);
  if (point.primitive.uniform_colors) return {colors[0].x, colors[0].y, colors[0].z};
  const auto color = [&](int corner) {
    const V4f& c = colors[point.Local(corner)];
    return V3d(c.x, c.y, c.z);
  };
  // In this form, equal colours come out exactly.
  const V3d first = color(0);
  return first + point.weights[1] * (color(1) - first) + point.weights[2] * (color(2) - first);
}

/// Whether the frame has the texture and the mesh the coordinates for it.
bool IsUsed(const FrameScene& frame, const MeshPrimitive& source, const TextureRef& reference) {
  if (reference.texture < 0 || reference.texcoord < 0 || reference.texcoord > 1) return false;
  const int image = frame.scene->textures[size_t(reference.texture)].image;
  return frame.Pyramid(image, TextureEncoding::kSrgb) != nullptr &&
         !source.texcoords[size_t(reference.texcoord)].empty();
}

/// Texture colour; white where the texture is not used.
V3d TextureColor(const ShadingPoint& point, const TextureRef& reference) {
  const MeshPrimitive& source = *point.primitive.source;
  if (!IsUsed(point.frame, source, reference)) return V3d(1);
  const std::vector<V2f>& coordinates = source.texcoords[size_t(reference.texcoord)];
  const V2d uv0(coordinates[point.Local(0)]), uv1(coordinates[point.Local(1)]),
      uv2(coordinates[point.Local(2)]);
  const V2d along1 = uv1 - uv0, along2 = uv2 - uv0;
  const V2d uv = uv0 + point.weights[1] * along1 + point.weights[2] * along2;
  const Footprint& f = point.footprint;
  const Texture& texture = point.frame.scene->textures[size_t(reference.texture)];
  return V3d(SampleTexture(*point.frame.Pyramid(texture.image, TextureEncoding::kSrgb), texture, uv,
                           f.db1_dx * along1 + f.db2_dx * along2, f.db1_dy * along1 + f.db2_dy * along2));
}

/// Cosine between the surface's normal and the direction to the camera, either side up, at mid-shutter.
double CosineToCamera(const ShadingPoint& point) {
  // Barycentric coordinates are those of the triangle in space, so positions in view space interpolate
  // without a division by depth.
  std::array<V3d, 3> corners;
  V3d position(0), normal(0);
  for (int k = 0; k < 3; ++k) {
    const uint32_t vertex = point.triangle.vertices[size_t(k)];
    corners[size_t(k)] = point.frame.view.ViewFromRaster(point.frame.VertexAt(point.primitive, vertex, 0.5));
    position += point.weights[size_t(k)] * corners[size_t(k)];
    if (point.primitive.has_normals) {
      normal +=
          point.weights[size_t(k)] * V3d(point.frame.normals[point.primitive.first_normal + point.Local(k)]);
    }
>>>>>>> materials
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
