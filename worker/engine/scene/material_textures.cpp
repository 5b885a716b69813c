#include "worker/engine/scene/material_textures.h"

namespace shutterline::engine {

std::vector<MaterialTexture> TexturesOf(const Material& material) {
  std::vector<MaterialTexture> textures;
  const auto add = [&](const char* role, const TextureRef& reference, TextureEncoding encoding) {
    if (reference.texture >= 0) textures.push_back({role, &reference, encoding});
  };
  add("base color", material.base_color_texture, TextureEncoding::kSrgb);
  if (material.unlit) return textures;
  add("metallic-roughness", material.metallic_roughness_texture, TextureEncoding::kLinear);
  add("normal", material.normal_texture, TextureEncoding::kLinear);
  add("occlusion", material.occlusion_texture, TextureEncoding::kLinear);
  add("emissive", material.emissive_texture, TextureEncoding::kSrgb);
  add("specular", material.specular_texture, TextureEncoding::kLinear);
  add("specular color", material.specular_color_texture, TextureEncoding::kSrgb);
  return textures;
}

bool ShowsNormalTexture(const Material& material, const MeshPrimitive& primitive) {
  return !material.unlit && material.normal_texture.texture >= 0 &&
         !primitive.texcoords[size_t(material.normal_texture.texcoord)].empty();
}

}  // namespace shutterline::engine
