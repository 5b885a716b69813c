#include "worker/engine/scene/gltf_texture.h"

#include <absl/strings/str_cat.h>

#include <utility>

#include "common/base/status_macros.h"
#include "common/base/work_limit.h"
#include "worker/engine/scene/gltf_image.h"
#include "worker/engine/scene/gltf_uri.h"

namespace shutterline::engine {
namespace {

WrapMode WrapOf(int code) {
  if (code == TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE) return WrapMode::kClampToEdge;
  if (code == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT) return WrapMode::kMirroredRepeat;
  return WrapMode::kRepeat;
}

TextureTransform ReadTransform(const tinygltf::Value& in) {
  TextureTransform transform;
  const auto pair = [&](const char* name, V2d* out) {
    if (!in.Has(name)) return;
    const tinygltf::Value& values = in.Get(name);
    *out = V2d(values.Get(0).GetNumberAsDouble(), values.Get(1).GetNumberAsDouble());
  };
  pair("offset", &transform.offset);
  pair("scale", &transform.scale);
  if (in.Has("rotation")) transform.rotation = in.Get("rotation").GetNumberAsDouble();
  return transform;
}

}  // namespace

GltfTextureInfo::GltfTextureInfo(const tinygltf::Value& extension, const char* name) {
  if (!extension.Has(name)) return;
  const tinygltf::Value& info = extension.Get(name);
  index = info.Get("index").GetNumberAsInt();
  if (info.Has("texCoord")) texcoord = info.Get("texCoord").GetNumberAsInt();
  if (!info.Has("extensions")) return;
  const tinygltf::Value& extensions = info.Get("extensions");
  if (extensions.Has("KHR_texture_transform")) transform = &extensions.Get("KHR_texture_transform");
}

absl::Status GltfTextureImporter::Import(const GltfTextureInfo& info, absl::string_view role,
                                         TextureRef* out) {
  if (info.index < 0) return absl::OkStatus();
  out->texcoord = info.texcoord;
  if (info.transform != nullptr) {
    out->transform = ReadTransform(*info.transform);
    if (info.transform->Has("texCoord")) out->texcoord = info.transform->Get("texCoord").GetNumberAsInt();
  }
  if (out->texcoord > 1) {
    return absl::UnimplementedError(
        absl::StrCat(role, ": texCoord ", out->texcoord, ": only sets 0 and 1 are supported"));
  }
  SL_ASSIGN_OR_RETURN(out->texture, ImportTexture(info.index));
  return absl::OkStatus();
}

absl::StatusOr<int> GltfTextureImporter::ImportTexture(int index) {
  if (const auto known = textures_.find(index); known != textures_.end()) return known->second;
  const tinygltf::Texture& texture = document_.model.textures[size_t(index)];
  if (texture.source < 0) {
    document_.Warn(absl::StrCat("texture ", index, ": it has no source and is left out"));
    return textures_[index] = -1;
  }
  Texture result;
  SL_ASSIGN_OR_RETURN(result.image, ImportImage(texture.source));
  if (texture.sampler >= 0) {
    const tinygltf::Sampler& sampler = document_.model.samplers[size_t(texture.sampler)];
    result.wrap_s = WrapOf(sampler.wrapS);
    result.wrap_t = WrapOf(sampler.wrapT);
    result.nearest = sampler.magFilter == TINYGLTF_TEXTURE_FILTER_NEAREST;
  }
  scene_.textures.push_back(result);
  return textures_[index] = int(scene_.textures.size()) - 1;
}

absl::StatusOr<int> GltfTextureImporter::ImportImage(int index) {
  if (const auto known = images_.find(index); known != images_.end()) return known->second;
  const GltfImageSource& source = document_.images[size_t(index)];
  CheckWork();
  absl::StatusOr<TextureImage> image = DecodeImage(source);
  if (!image.ok()) return Annotate(image.status(), GltfElement("image", size_t(index), source.name));
  image->name = source.name;
  scene_.images.push_back(*std::move(image));
  return images_[index] = int(scene_.images.size()) - 1;
}

absl::StatusOr<TextureImage> GltfTextureImporter::DecodeImage(const GltfImageSource& source) {
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
  const ImportLimits& limits = document_.limits;
  document_.texture_pixels.RaiseWithin(bytes.size() * limits.texture_pixels_per_byte,
                                       limits.max_texture_pixels);
  return DecodeGltfImage(bytes, limits.max_image_side, &document_.texture_pixels);
}

}  // namespace shutterline::engine
