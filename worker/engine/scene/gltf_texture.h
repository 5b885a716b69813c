#pragma once

#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>

#include <map>

#include "worker/engine/scene/gltf_document.h"
#include "worker/engine/scene/scene.h"

namespace shutterline::engine {

/// A texture as a material of the file names it: what tinygltf's four kinds of texture infos and those inside
/// of extensions have in common.
struct GltfTextureInfo {
  int index = -1;
  int texcoord = 0;
  const tinygltf::Value* transform = nullptr;  ///< KHR_texture_transform, where there is one.

  GltfTextureInfo() = default;
  /// Of tinygltf's TextureInfo, NormalTextureInfo and OcclusionTextureInfo.
  template <typename Info>
  explicit GltfTextureInfo(const Info& info) : index(info.index), texcoord(info.texCoord) {
    const auto found = info.extensions.find("KHR_texture_transform");
    if (found != info.extensions.end()) transform = &found->second;
  }
  /// Of member `name` of an extension of a material; none where it has none.
  GltfTextureInfo(const tinygltf::Value& extension, const char* name);
};

/// Imports those textures and images that are asked for, each once.
class GltfTextureImporter {
 public:
  GltfTextureImporter(GltfDocument* document, Scene* scene) : document_(*document), scene_(*scene) {}

  /// Leaves `out` as it is where `info` names no texture.
  absl::Status Import(const GltfTextureInfo& info, absl::string_view role, TextureRef* out);

 private:
  absl::StatusOr<int> ImportTexture(int index);
  absl::StatusOr<int> ImportImage(int index);
  absl::StatusOr<TextureImage> DecodeImage(const GltfImageSource& source);

  GltfDocument& document_;
  Scene& scene_;
  std::map<int, int> textures_, images_;  ///< Number in the file to number in the scene.
};

}  // namespace shutterline::engine
