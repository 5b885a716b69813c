#include "worker/engine/scene/gltf_material.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <cfloat>
#include <utility>

#include "common/base/status_macros.h"
#include "worker/engine/scene/gltf_texture.h"

namespace shutterline::engine {
namespace {

/// A material of the file in the middle of its import.
class MaterialReader {
 public:
  MaterialReader(const tinygltf::Material& in, std::string element, GltfDocument* document,
                 GltfTextureImporter* textures)
      : in_(in), element_(std::move(element)), document_(*document), textures_(*textures) {}

  absl::StatusOr<Material> Read() {
    out_.name = in_.name;
    out_.double_sided = in_.doubleSided;
    out_.unlit = Extension("KHR_materials_unlit") != nullptr;
    ReadAlpha();
    SL_RETURN_IF_ERROR(ReadBaseColor());
    if (!out_.unlit) {
      SL_RETURN_IF_ERROR(ReadMetalAndRoughness());
      SL_RETURN_IF_ERROR(ReadRelief());
      SL_RETURN_IF_ERROR(ReadSpecular());
    }
    SL_RETURN_IF_ERROR(ReadEmission());
    return std::move(out_);
  }

 private:
  void ReadAlpha() {
    out_.alpha_mode = in_.alphaMode == "MASK"    ? AlphaMode::kMask
                      : in_.alphaMode == "BLEND" ? AlphaMode::kBlend
                                                 : AlphaMode::kOpaque;
    out_.alpha_cutoff = Within(0, FLT_MAX, in_.alphaCutoff, "alphaCutoff");
  }

  absl::Status ReadBaseColor() {
    const tinygltf::PbrMetallicRoughness& pbr = in_.pbrMetallicRoughness;
    for (size_t i = 0; i < 4 && pbr.baseColorFactor.size() == 4; ++i) {
      out_.base_color_factor[int(i)] = Within(0, 1, pbr.baseColorFactor[i], "baseColorFactor");
    }
    return Texture(GltfTextureInfo(pbr.baseColorTexture), "baseColorTexture", &out_.base_color_texture);
  }

  absl::Status ReadMetalAndRoughness() {
    const tinygltf::PbrMetallicRoughness& pbr = in_.pbrMetallicRoughness;
    out_.metallic_factor = Within(0, 1, pbr.metallicFactor, "metallicFactor");
    out_.roughness_factor = Within(0, 1, pbr.roughnessFactor, "roughnessFactor");
    return Texture(GltfTextureInfo(pbr.metallicRoughnessTexture), "metallicRoughnessTexture",
                   &out_.metallic_roughness_texture);
  }

  absl::Status ReadRelief() {
    out_.normal_scale = float(in_.normalTexture.scale);
    out_.occlusion_strength = Within(0, 1, in_.occlusionTexture.strength, "occlusionTexture.strength");
    SL_RETURN_IF_ERROR(Texture(GltfTextureInfo(in_.normalTexture), "normalTexture", &out_.normal_texture));
    return Texture(GltfTextureInfo(in_.occlusionTexture), "occlusionTexture", &out_.occlusion_texture);
  }

  absl::Status ReadEmission() {
    double strength = 1;
    if (const auto* extension = Extension("KHR_materials_emissive_strength")) {
      strength = Within(0, FLT_MAX, Number(*extension, "emissiveStrength", 1), "emissiveStrength");
    }
    for (size_t i = 0; i < 3 && in_.emissiveFactor.size() == 3; ++i) {
      const double factor = Within(0, FLT_MAX, in_.emissiveFactor[i], "emissiveFactor");
      out_.emissive_factor[int(i)] = float(std::min(factor * strength, double(FLT_MAX)));
    }
    if (out_.unlit) return absl::OkStatus();
    return Texture(GltfTextureInfo(in_.emissiveTexture), "emissiveTexture", &out_.emissive_texture);
  }

  absl::Status ReadSpecular() {
    if (const auto* extension = Extension("KHR_materials_ior")) {
      const double ior = Number(*extension, "ior", 1.5);
      out_.ior = ior == 0 ? 0 : Within(1, FLT_MAX, ior, "ior");
    }
    const auto* extension = Extension("KHR_materials_specular");
    if (extension == nullptr) return absl::OkStatus();
    out_.specular_factor = Within(0, 1, Number(*extension, "specularFactor", 1), "specularFactor");
    for (int i = 0; i < 3 && extension->Has("specularColorFactor"); ++i) {
      const double factor = extension->Get("specularColorFactor").Get(i).GetNumberAsDouble();
      out_.specular_color_factor[i] = Within(0, FLT_MAX, factor, "specularColorFactor");
    }
    SL_RETURN_IF_ERROR(
        Texture(GltfTextureInfo(*extension, "specularTexture"), "specularTexture", &out_.specular_texture));
    return Texture(GltfTextureInfo(*extension, "specularColorTexture"), "specularColorTexture",
                   &out_.specular_color_texture);
  }

  absl::Status Texture(const GltfTextureInfo& info, absl::string_view role, TextureRef* out) {
    return textures_.Import(info, role, out);
  }

  /// Null where the material does not have it.
  const tinygltf::Value* Extension(const char* name) const {
    const auto found = in_.extensions.find(name);
    return found == in_.extensions.end() ? nullptr : &found->second;
  }
  static double Number(const tinygltf::Value& extension, const char* name, double otherwise) {
    return extension.Has(name) ? extension.Get(name).GetNumberAsDouble() : otherwise;
  }

  float Within(double low, double high, double value, absl::string_view name) {
    const double moved = std::clamp(value, low, high);
    if (moved != value) document_.Warn(absl::StrCat(element_, ": ", name, " ", value, " taken as ", moved));
    return float(moved);
  }

  const tinygltf::Material& in_;
  const std::string element_;
  GltfDocument& document_;
  GltfTextureImporter& textures_;
  Material out_;
};

}  // namespace

absl::Status ImportGltfMaterials(GltfDocument* document, Scene* scene) {
  GltfTextureImporter textures(document, scene);
  for (size_t m = 0; m < document->model.materials.size(); ++m) {
    const tinygltf::Material& in = document->model.materials[m];
    const std::string element = GltfElement("material", m, in.name);
    absl::StatusOr<Material> material = MaterialReader(in, element, document, &textures).Read();
    if (!material.ok()) return Annotate(material.status(), element);
    scene->materials.push_back(*std::move(material));
  }
  scene->materials.emplace_back();
  scene->materials.back().name = "default";
  return absl::OkStatus();
}

}  // namespace shutterline::engine
