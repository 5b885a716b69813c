#include <fstream>  // Which the implementation of tinygltf forgets where it has no file system.

#define TINYGLTF_IMPLEMENTATION
#include "worker/engine/scene/gltf_tiny.h"

#include <absl/status/status.h>
#include <absl/strings/str_cat.h>

#include <limits>
#include <nlohmann/json.hpp>
#include <string>

#include "common/base/status_macros.h"

namespace shutterline::engine {
namespace {

using Json = nlohmann::json;

size_t Count(const Json& object, const char* array) {
  const auto found = object.find(array);
  return found == object.end() ? 0 : found->size();
}

/// Whether the model has every element of the document, so that indices mean what they did there.
bool KeptEverything(const Json& document, const tinygltf::Model& model) {
  if (model.bufferViews.size() != Count(document, "bufferViews") ||
      model.accessors.size() != Count(document, "accessors") ||
      model.nodes.size() != Count(document, "nodes") || model.scenes.size() != Count(document, "scenes") ||
      model.meshes.size() != Count(document, "meshes") ||
      model.materials.size() != Count(document, "materials") ||
      model.skins.size() != Count(document, "skins") ||
      model.textures.size() != Count(document, "textures") ||
      model.samplers.size() != Count(document, "samplers") ||
      model.cameras.size() != Count(document, "cameras") ||
      model.animations.size() != Count(document, "animations")) {
    return false;
  }
  for (size_t m = 0; m < model.meshes.size(); ++m) {
    const Json& mesh = document["meshes"][m];
    if (model.meshes[m].primitives.size() != Count(mesh, "primitives")) return false;
    for (size_t p = 0; p < model.meshes[m].primitives.size(); ++p) {
      if (model.meshes[m].primitives[p].targets.size() != Count(mesh["primitives"][p], "targets"))
        return false;
    }
  }
  for (size_t a = 0; a < model.animations.size(); ++a) {
    const Json& animation = document["animations"][a];
    if (model.animations[a].channels.size() != Count(animation, "channels")) return false;
    if (model.animations[a].samplers.size() != Count(animation, "samplers")) return false;
  }
  return true;
}

}  // namespace

absl::StatusOr<tinygltf::Model> ReadWithTinyGltf(const Json& conforming) {
  Json document = conforming;
  document.erase("buffers");
  document.erase("images");
  document.erase("extensions");
  tinygltf::Model model;
  std::string errors, warnings;
  try {
    const std::string text = document.dump();
    if (text.size() > std::numeric_limits<unsigned int>::max()) {
      return absl::ResourceExhaustedError("JSON: longer than 4 GiB");
    }
    tinygltf::TinyGLTF loader;
    if (!loader.LoadASCIIFromString(&model, &errors, &warnings, text.data(), unsigned(text.size()), "",
                                    tinygltf::NO_REQUIRE)) {
      return absl::InvalidArgumentError(absl::StrCat("glTF: ", errors));
    }
  } catch (const std::exception& error) {
    return absl::InvalidArgumentError(absl::StrCat("glTF: ", error.what()));
  }
  if (!KeptEverything(document, model)) {
    return absl::InternalError(absl::StrCat("glTF: the parser left elements out: ", errors));
  }
  return model;
}

}  // namespace shutterline::engine
