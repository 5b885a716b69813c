#include "worker/engine/shading/prepared_material.h"

#include <algorithm>

#include "worker/engine/shading/texture_lookup.h"

namespace shutterline::engine {
namespace {

bool AreEqual(const TextureTransform& a, const TextureTransform& b) {
  return a.offset == b.offset && a.rotation == b.rotation && a.scale == b.scale;
}

}  // namespace

PreparedMaterial::PreparedMaterial(const FrameScene& frame, const FramePrimitive& primitive) {
  const Material& material = *primitive.material;
  const auto prepare = [&](TextureSlot slot, const TextureRef& reference, TextureEncoding encoding) {
    textures_[size_t(slot)] = Prepare(frame, *primitive.source, reference, encoding);
  };
  constexpr TextureEncoding kSrgb = TextureEncoding::kSrgb, kLinear = TextureEncoding::kLinear;
  prepare(TextureSlot::kBaseColor, material.base_color_texture, kSrgb);
  prepare(TextureSlot::kMetallicRoughness, material.metallic_roughness_texture, kLinear);
  if (primitive.has_tangents) prepare(TextureSlot::kNormal, material.normal_texture, kLinear);
  prepare(TextureSlot::kOcclusion, material.occlusion_texture, kLinear);
  prepare(TextureSlot::kEmissive, material.emissive_texture, kSrgb);
  prepare(TextureSlot::kSpecular, material.specular_texture, kLinear);
  prepare(TextureSlot::kSpecularColor, material.specular_color_texture, kSrgb);
  // An index of 0 stands for infinity: everything is mirrored [KHR_materials_ior].
  const double r = material.ior == 0 ? 1 : (double(material.ior) - 1) / (double(material.ior) + 1);
  head_on = r * r;
}

PreparedTexture PreparedMaterial::Prepare(const FrameScene& frame, const MeshPrimitive& source,
                                          const TextureRef& reference, TextureEncoding encoding) {
  PreparedTexture made;
  made.pyramid = PyramidOf(frame, source, reference, encoding);
  if (made.pyramid == nullptr) return made;
  made.image = WalkedImage(*made.pyramid, frame.scene->textures[size_t(reference.texture)]);
  made.coordinates = CoordinatesOf(source.texcoords[size_t(reference.texcoord)], reference.transform);
  made.walk = WalkOf(made.coordinates, made.image);
  return made;
}

int PreparedMaterial::CoordinatesOf(const std::vector<V2f>& of_vertices, const TextureTransform& transform) {
  const auto found = std::find_if(coordinates_.begin(), coordinates_.end(), [&](const Coordinates& known) {
    return known.of_vertices == &of_vertices && AreEqual(known.transform, transform);
  });
  const auto number = int(found - coordinates_.begin());
  if (found != coordinates_.end()) return number;
  coordinates_.push_back({&of_vertices, transform, std::nullopt});
  if (!transform.IsIdentity()) coordinates_.back().turned.emplace(transform);
  return number;
}

int PreparedMaterial::WalkOf(int coordinates, const WalkedImage& image) {
  const auto found = std::find(walks_.begin(), walks_.end(), std::pair(coordinates, image));
  const auto number = int(found - walks_.begin());
  if (found == walks_.end()) walks_.emplace_back(coordinates, image);
  return number;
}

TriangleCoordinates PreparedMaterial::CoordinatesOn(int n, const std::array<size_t, 3>& corners) const {
  const Coordinates& of = coordinates_[size_t(n)];
  const V2d origin((*of.of_vertices)[corners[0]]);
  const V2d along1 = V2d((*of.of_vertices)[corners[1]]) - origin;
  const V2d along2 = V2d((*of.of_vertices)[corners[2]]) - origin;
  if (!of.turned) return {origin, along1, along2};
  const TurnAndScale& turned = *of.turned;
  return {of.transform.offset + turned(origin), turned(along1), turned(along2)};
}

}  // namespace shutterline::engine
