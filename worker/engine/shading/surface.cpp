#include "worker/engine/shading/surface.h"

#include <algorithm>
#include <cmath>

#include "common/math/unit_vector.h"
#include "worker/engine/scene/material_textures.h"
#include "worker/engine/shading/texture_lookup.h"

namespace shutterline::engine {
namespace {

std::array<size_t, 3> CornersInMesh(const FramePrimitive& primitive, const FrameTriangle& triangle) {
  std::array<size_t, 3> corners;
  for (size_t k = 0; k < 3; ++k) corners[k] = triangle.vertices[k] - primitive.first_vertex;
  return corners;
}

V4d VertexColor(const FramePrimitive& primitive, const std::array<size_t, 3>& corners,
                const Barycentric& at) {
  const std::vector<V4f>& colors = primitive.source->colors;
  if (colors.empty()) return V4d(1);
  if (primitive.uniform_colors) return V4d(colors[0]);
  // In this form, equal colours come out exactly.
  const V4d first(colors[corners[0]]);
  return first + at.b1 * (V4d(colors[corners[1]]) - first) + at.b2 * (V4d(colors[corners[2]]) - first);
}

V4d BaseColor(const FramePrimitive& primitive, const PreparedMaterial& material,
              const std::array<size_t, 3>& corners, const Barycentric& at, TextureLookup& textures) {
  return TintAt(primitive, corners, at) * textures.Color(material.Of(TextureSlot::kBaseColor));
}

V3d Rgb(const V4d& color) {
  return {color.x, color.y, color.z};
}

/// The normal that a texture asks for, in the frame of tangent, bitangent and `normal`.
V3d TexturedNormal(const FrameScene& frame, const SurfaceTriangle& triangle,
                   const std::array<double, 3>& weights, TextureLookup& textures, const V3d& normal) {
  const Material& material = *triangle.primitive->material;
  const V4d texel = textures.Color(triangle.material->Of(TextureSlot::kNormal));
  const V3d bent(material.normal_scale * (2 * texel.x - 1), material.normal_scale * (2 * texel.y - 1),
                 2 * texel.z - 1);
  const size_t first = triangle.FirstTangent();
  V3d tangent(0);
  double sign = 0;
  for (size_t k = 0; k < 3; ++k) {
    const V4f& t = frame.tangents[first + k];
    tangent += weights[k] * V3d(t.x, t.y, t.z);
    sign += weights[k] * double(t.w);
  }
  tangent = UnitOrZero(tangent - normal.dot(tangent) * normal);
  const V3d bitangent = (sign < 0 ? -1.0 : 1.0) * normal.cross(tangent);
  const V3d turned = UnitOrZero(bent.x * tangent + bent.y * bitangent + bent.z * normal);
  return turned == V3d(0) ? normal : turned;
}

void PlaceInSpace(const FrameScene& frame, const SurfaceTriangle& triangle,
                  const std::array<double, 3>& weights, TextureLookup& textures, Surface& surface) {
  // Barycentric coordinates are those of the triangle in space, so positions in view space interpolate
  // without a division by depth.
  const FramePrimitive& primitive = *triangle.primitive;
  V3d position(0), normal(0);
  for (size_t k = 0; k < 3; ++k) {
    position += weights[k] * triangle.corners[k];
    if (primitive.has_normals) {
      normal += weights[k] * V3d(frame.normals[primitive.first_normal + triangle.textured.corners[k]]);
    }
  }
  surface.position = position;
  surface.to_camera = frame.view.perspective ? UnitOrZero(-position) : V3d(0, 0, 1);
  V3d face = triangle.face;
  normal = UnitOrZero(normal);
  if (normal == V3d(0)) normal = face;
  if (face == V3d(0)) face = normal;
  // Where a direction is undefined, the surface is seen head-on.
  if (surface.to_camera == V3d(0)) surface.to_camera = face;
  if (face == V3d(0)) face = normal = surface.to_camera;
  if (face == V3d(0)) face = normal = surface.to_camera = V3d(0, 0, 1);
  // Files whose normals point inwards are meant to be seen all the same.
  if (normal.dot(face) < 0) normal = -normal;
  if (primitive.has_tangents) normal = TexturedNormal(frame, triangle, weights, textures, normal);
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

SurfaceTriangle::SurfaceTriangle(const FrameScene& frame, const PreparedMaterial& of_material,
                                 uint32_t triangle)
    : number(triangle), material(&of_material) {
  const FrameTriangle& source = frame.triangles[triangle];
  primitive = &frame.primitives[source.primitive];
  textured = TexturedTriangle(*material, CornersInMesh(*primitive, source));
  for (size_t k = 0; k < 3; ++k) {
    raster[k] = frame.VertexAt(*primitive, source.vertices[k], 0.5);
    corners[k] = frame.view.ViewFromRaster(raster[k]);
  }
  const V3d edge1 = corners[1] - corners[0], edge2 = corners[2] - corners[0];
  face = UnitOrZero(edge1.cross(edge2));
  // Products of edges that are tiny or huge are nothing.
  if (face == V3d(0)) face = UnitOrZero(UnitOrZero(edge1).cross(UnitOrZero(edge2)));
}

V4d TintAt(const FramePrimitive& primitive, const std::array<size_t, 3>& corners, const Barycentric& at) {
  return V4d(primitive.material->base_color_factor) * VertexColor(primitive, corners, at);
}

V4d BaseColorAt(const FramePrimitive& primitive, const PreparedMaterial& material,
                const FrameTriangle& triangle, const Barycentric& at, const Footprint& footprint) {
  const TexturedTriangle textured(material, CornersInMesh(primitive, triangle));
  TextureLookup textures(material, textured, at, footprint);
  return BaseColor(primitive, material, textured.corners, at, textures);
}

Surface SurfaceAt(const FrameScene& frame, const SurfaceTriangle& triangle, const Barycentric& at,
                  const Footprint& footprint) {
  const FramePrimitive& primitive = *triangle.primitive;
  const Material& material = *primitive.material;
  const PreparedMaterial& prepared = *triangle.material;
  const std::array<double, 3> weights{1 - at.b1 - at.b2, at.b1, at.b2};
  TextureLookup textures(prepared, triangle.textured, at, footprint);
  // What nearly all textured materials have is fetched while the surface is placed.
  textures.Prefetch(prepared.Of(TextureSlot::kBaseColor));
  textures.Prefetch(prepared.Of(TextureSlot::kMetallicRoughness));
  textures.Prefetch(prepared.Of(TextureSlot::kNormal));
  Surface surface;
  PlaceInSpace(frame, triangle, weights, textures, surface);
  surface.base_color = Rgb(BaseColor(primitive, prepared, triangle.textured.corners, at, textures));

  const V4d metallic_roughness = textures.Color(prepared.Of(TextureSlot::kMetallicRoughness));
  surface.metallic = std::clamp(material.metallic_factor * metallic_roughness.z, 0.0, 1.0);
  surface.roughness = std::clamp(material.roughness_factor * metallic_roughness.y, 0.0, 1.0);

  const double specular = material.specular_factor * textures.Color(prepared.Of(TextureSlot::kSpecular)).w;
  const V3d tint =
      V3d(material.specular_color_factor) * Rgb(textures.Color(prepared.Of(TextureSlot::kSpecularColor)));
  for (int c = 0; c < 3; ++c) {
    const double dielectric = std::min(prepared.head_on * tint[c], 1.0) * specular;
    surface.f0[c] = dielectric + surface.metallic * (surface.base_color[c] - dielectric);
  }
  surface.f90 = specular + surface.metallic * (1 - specular);

  if (material.occlusion_texture.texture >= 0) {
    const double open = textures.Color(prepared.Of(TextureSlot::kOcclusion)).x;
    surface.occlusion = 1 + material.occlusion_strength * (open - 1);
  }
  if (material.emissive_factor != V3f(0)) {
    surface.emission =
        V3d(material.emissive_factor) * Rgb(textures.Color(prepared.Of(TextureSlot::kEmissive)));
  }
  return surface;
}

}  // namespace shutterline::engine
