#include "worker/engine/scene/gltf_material.h"

#include <absl/strings/str_cat.h>

#include <map>

#include "common/base/status_macros.h"
#include "worker/engine/scene/gltf_image.h"
#include "worker/engine/scene/gltf_uri.h"

namespace shutterline::engine {
namespace {

WrapMode WrapOf(int code) {
  if (code == TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE) return WrapMode::kClampToEdge;
  if (code == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT) return WrapMode::kMirroredRepeat;
  return WrapMode::kRepeat;
}

class MaterialImporter {
 public:
  MaterialImporter(GltfDocument* document, Scene* scene) : document_(*document), scene_(*scene) {}

  absl::Status ImportAll() {
    for (size_t m = 0; m < document_.model.materials.size(); ++m) {
      const tinygltf::Material& in = document_.model.materials[m];
      const std::string element = GltfElement("material", m, in.name);
      Material material;
      SL_RETURN_IF_ERROR(Annotate(ImportMaterial(in, element, &material), element));
      scene_.materials.push_back(std::move(material));
    }
    scene_.materials.emplace_back();
    scene_.materials.back().name = "default";
    return absl::OkStatus();
  }

 private:
  absl::Status ImportMaterial(const tinygltf::Material& in, const std::string& element, Material* out) {
    const tinygltf::PbrMetallicRoughness& pbr = in.pbrMetallicRoughness;
    out->name = in.name;
    out->double_sided = in.doubleSided;
    out->unlit = in.extensions.count("KHR_materials_unlit") > 0;
    if (pbr.baseColorFactor.size() == 4) {
      for (int i = 0; i < 4; ++i) out->base_color_factor[i] = float(pbr.baseColorFactor[size_t(i)]);
    }
    if (in.emissiveFactor.size() == 3) {
      for (int i = 0; i < 3; ++i) out->emissive_factor[i] = float(in.emissiveFactor[size_t(i)]);
    }
    SL_RETURN_IF_ERROR(
        ImportTexture(pbr.baseColorTexture, element, "baseColorTexture", &out->base_color_texture));
    return ImportTexture(in.emissiveTexture, element, "emissiveTexture", &out->emissive_texture);
  }

  absl::Status ImportTexture(const tinygltf::TextureInfo& in, const std::string& element,
                             absl::string_view role, TextureRef* out) {
    if (in.index < 0) return absl::OkStatus();
    if (in.texCoord > 1) {
      return absl::UnimplementedError(
          absl::StrCat(role, ": texCoord ", in.texCoord, ": only sets 0 and 1 are supported"));
    }
    if (in.extensions.count("KHR_texture_transform") > 0) {
      document_.Warn(absl::StrCat(element, ": ", role, ": KHR_texture_transform is ignored"));
    }
    out->texcoord = in.texCoord;
    if (const auto known = textures_.find(in.index); known != textures_.end()) {
      out->texture = known->second;
      return absl::OkStatus();
    }
    const tinygltf::Texture& texture = document_.model.textures[size_t(in.index)];
    int number = -1;
    if (texture.source < 0) {
      document_.Warn(absl::StrCat("texture ", in.index, ": it has no source and is left out"));
    } else {
      Texture result;
      SL_ASSIGN_OR_RETURN(result.image, ImportImage(texture.source));
      if (texture.sampler >= 0) {
        const tinygltf::Sampler& sampler = document_.model.samplers[size_t(texture.sampler)];
        result.wrap_s = WrapOf(sampler.wrapS);
        result.wrap_t = WrapOf(sampler.wrapT);
        result.nearest = sampler.magFilter == TINYGLTF_TEXTURE_FILTER_NEAREST;
      }
      number = int(scene_.textures.size());
      scene_.textures.push_back(result);
    }
    textures_[in.index] = number;
    out->texture = number;
    return absl::OkStatus();
  }

  absl::StatusOr<int> ImportImage(int index) {
    if (const auto known = images_.find(index); known != images_.end()) return known->second;
    const GltfImageSource& source = document_.images[size_t(index)];
    absl::StatusOr<TextureImage> image = DecodeImage(source);
    if (!image.ok()) return Annotate(image.status(), GltfElement("image", size_t(index), source.name));
    image->name = source.name;
    scene_.images.push_back(*std::move(image));
    return images_[index] = int(scene_.images.size()) - 1;
  }

  absl::StatusOr<TextureImage> DecodeImage(const GltfImageSource& source) {
    std::string storage;
    absl::string_view bytes;
    if (source.buffer_view >= 0) {
      bytes = document_.ViewBytes(source.buffer_view);
    } else if (source.uri.empty()) {
      return absl::InvalidArgumentError("it has neither a uri nor a bufferView");
    } else if (IsDataUri(source.uri)) {
      SL_ASSIGN_OR_RETURN(storage, DecodeDataUri(source.uri, document_.limits.max_file_bytes));
      bytes = storage;
    } else {
      SL_ASSIGN_OR_RETURN(const std::string name, DecodeFileUri(source.uri));
      SL_ASSIGN_OR_RETURN(storage, document_.source.Read(name, document_.limits.max_file_bytes));
      bytes = storage;
    }
    return DecodeGltfImage(bytes, document_.limits.max_image_side, &document_.texture_pixels);
  }

  GltfDocument& document_;
  Scene& scene_;
  std::map<int, int> textures_, images_;  ///< Number in the file to number in the scene.
};

}  // namespace

absl::Status ImportGltfMaterials(GltfDocument* document, Scene* scene) {
  return MaterialImporter(document, scene).ImportAll();
}

}  // namespace shutterline::engine
