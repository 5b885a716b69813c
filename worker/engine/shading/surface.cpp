#include "worker/engine/shading/surface.h"

#include <algorithm>
#include <cmath>

#include "common/math/unit_vector.h"
#include "worker/engine/scene/material_textures.h"
#include "worker/engine/shading/texture_lookup.h"

namespace shutterline::engine {
namespace {

/// A point of a triangle, with what interpolation needs.
struct Point {
  Point(const FrameScene& of_frame, const FramePrimitive& of_primitive, const FrameTriangle& of_triangle,
        const Barycentric& at, const Footprint& footprint)
      : frame(of_frame),
        primitive(of_primitive),
        triangle(of_triangle),
        weights{1 - at.b1 - at.b2, at.b1, at.b2},
        textures(frame, *primitive.source, local, weights, footprint) {
    for (size_t k = 0; k < 3; ++k) local[k] = triangle.vertices[k] - primitive.first_vertex;
  }
  Point(const Point&) = delete;  // `textures` refers to its neighbours.

  const FrameScene& frame;
  const FramePrimitive& primitive;
  const FrameTriangle& triangle;
  std::array<double, 3> weights;  ///< Barycentric, of the triangle's three corners.
  std::array<size_t, 3> local;    ///< The corners' numbers in the mesh.
  TextureLookup textures;
};

V4d VertexColor(const Point& point) {
  const std::vector<V4f>& colors = point.primitive.source->colors;
  if (colors.empty()) return V4d(1);
  if (point.primitive.uniform_colors) return V4d(colors[0]);
  // In this form, equal colours come out exactly.
  const V4d first(colors[point.local[0]]);
  return first + point.weights[1] * (V4d(colors[point.local[1]]) - first) +
         point.weights[2] * (V4d(colors[point.local[2]]) - first);
}

V4d BaseColor(Point& point) {
  const Material& material = *point.primitive.material;
  return V4d(material.base_color_factor) * VertexColor(point) *
         point.textures.Color(material.base_color_texture, TextureEncoding::kSrgb);
}

V3d Rgb(const V4d& color) {
  return {color.x, color.y, color.z};
}

/// The normal that a texture asks for, in the frame of tangent, bitangent and `normal`.
V3d TexturedNormal(Point& point, const Material& material, uint32_t index, const V3d& normal) {
  const V4d texel = point.textures.Color(material.normal_texture, TextureEncoding::kLinear);
  const V3d bent(material.normal_scale * (2 * texel.x - 1), material.normal_scale * (2 * texel.y - 1),
                 2 * texel.z - 1);
  const size_t first = point.primitive.first_tangent + 3 * size_t(index - point.primitive.first_triangle);
  V3d tangent(0);
  double sign = 0;
  for (size_t k = 0; k < 3; ++k) {
    const V4f& t = point.frame.tangents[first + k];
    tangent += point.weights[k] * V3d(t.x, t.y, t.z);
    sign += point.weights[k] * double(t.w);
  }
  tangent = UnitOrZero(tangent - normal.dot(tangent) * normal);
  const V3d bitangent = (sign < 0 ? -1.0 : 1.0) * normal.cross(tangent);
  const V3d turned = UnitOrZero(bent.x * tangent + bent.y * bitangent + bent.z * normal);
  return turned == V3d(0) ? normal : turned;
}

void PlaceInSpace(Point& point, const Material& material, uint32_t index, Surface& surface) {
  // Barycentric coordinates are those of the triangle in space, so positions in view space interpolate
  // without a division by depth.
  std::array<V3d, 3> corners;
  V3d position(0), normal(0);
  for (size_t k = 0; k < 3; ++k) {
    const uint32_t vertex = point.triangle.vertices[k];
    corners[k] = point.frame.view.ViewFromRaster(point.frame.VertexAt(point.primitive, vertex, 0.5));
    position += point.weights[k] * corners[k];
    if (point.primitive.has_normals) {
      normal += point.weights[k] * V3d(point.frame.normals[point.primitive.first_normal + point.local[k]]);
    }
  }
  surface.position = position;
  surface.to_camera = point.frame.view.perspective ? UnitOrZero(-position) : V3d(0, 0, 1);
  const V3d edge1 = corners[1] - corners[0], edge2 = corners[2] - corners[0];
  V3d face = UnitOrZero(edge1.cross(edge2));
  // Products of edges that are tiny or huge are nothing.
  if (face == V3d(0)) face = UnitOrZero(UnitOrZero(edge1).cross(UnitOrZero(edge2)));
  normal = UnitOrZero(normal);
  if (normal == V3d(0)) normal = face;
  if (face == V3d(0)) face = normal;
  // Where a direction is undefined, the surface is seen head-on.
  if (surface.to_camera == V3d(0)) surface.to_camera = face;
  if (face == V3d(0)) face = normal = surface.to_camera;
  if (face == V3d(0)) face = normal = surface.to_camera = V3d(0, 0, 1);
  // Files whose normals point inwards are meant to be seen all the same.
  if (normal.dot(face) < 0) normal = -normal;
  if (point.primitive.has_tangents) normal = TexturedNormal(point, material, index, normal);
  // Seen from behind, a surface is turned round with all that is on it.
  if (face.dot(surface.to_camera) < 0) {
    face = -face;
    normal = -normal;
  }
  surface.face = face;
  surface.normal = normal;
}

}  // namespace

bool IsTextured(const FrameScene& frame, const FramePrimitive& primitive) {
  const std::vector<MaterialTexture> textures = TexturesOf(*primitive.material);
  return std::any_of(textures.begin(), textures.end(), [&](const MaterialTexture& texture) {
    return IsUsed(frame, *primitive.source, *texture.reference, texture.encoding);
  });
}

V4d BaseColorAt(const FrameScene& frame, const FramePrimitive& primitive, const FrameTriangle& triangle,
                const Barycentric& at, const Footprint& footprint) {
  Point point(frame, primitive, triangle, at, footprint);
  return BaseColor(point);
}

Surface SurfaceAt(const FrameScene& frame, const FramePrimitive& primitive, const FrameTriangle& triangle,
                  uint32_t index, const Barycentric& at, const Footprint& footprint) {
  Point point(frame, primitive, triangle, at, footprint);
  const Material& material = *primitive.material;
  // What nearly all textured materials have is fetched while the surface is placed.
  point.textures.Prefetch(material.base_color_texture, TextureEncoding::kSrgb);
  point.textures.Prefetch(material.metallic_roughness_texture, TextureEncoding::kLinear);
  if (primitive.has_tangents) point.textures.Prefetch(material.normal_texture, TextureEncoding::kLinear);
  Surface surface;
  PlaceInSpace(point, material, index, surface);
  surface.base_color = Rgb(BaseColor(point));

  const V4d metallic_roughness =
      point.textures.Color(material.metallic_roughness_texture, TextureEncoding::kLinear);
  surface.metallic = std::clamp(material.metallic_factor * metallic_roughness.z, 0.0, 1.0);
  surface.roughness = std::clamp(material.roughness_factor * metallic_roughness.y, 0.0, 1.0);

  // An index of 0 stands for infinity: everything is mirrored [KHR_materials_ior].
  const double r = material.ior == 0 ? 1 : (double(material.ior) - 1) / (double(material.ior) + 1);
  const double specular =
      material.specular_factor * point.textures.Color(material.specular_texture, TextureEncoding::kLinear).w;
  const V3d tint = V3d(material.specular_color_factor) *
                   Rgb(point.textures.Color(material.specular_color_texture, TextureEncoding::kSrgb));
  for (int c = 0; c < 3; ++c) {
    const double dielectric = std::min(r * r * tint[c], 1.0) * specular;
    surface.f0[c] = dielectric + surface.metallic * (surface.base_color[c] - dielectric);
  }
  surface.f90 = specular + surface.metallic * (1 - specular);

  if (material.occlusion_texture.texture >= 0) {
    const double open = point.textures.Color(material.occlusion_texture, TextureEncoding::kLinear).x;
    surface.occlusion = 1 + material.occlusion_strength * (open - 1);
  }
  if (material.emissive_factor != V3f(0)) {
    surface.emission = V3d(material.emissive_factor) *
                       Rgb(point.textures.Color(material.emissive_texture, TextureEncoding::kSrgb));
  }
  return surface;
}

}  // namespace shutterline::engine
