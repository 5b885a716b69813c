#include "worker/engine/scene/scene_names.h"

#include <absl/strings/str_cat.h>

#include <exception>
#include <nlohmann/json.hpp>
#include <string>

#include "common/base/status_macros.h"
#include "worker/engine/scene/gltf_document.h"
#include "worker/engine/scene/gltf_import.h"

namespace shutterline::engine {
namespace {

std::string ObjectName(size_t node, const std::string& name, const std::string& mesh_name) {
  return !name.empty() ? name : !mesh_name.empty() ? mesh_name : absl::StrCat("node_", node);
}

std::string MaterialName(size_t index, size_t count, const std::string& name) {
  if (index == count) return "default";
  return !name.empty() ? name : absl::StrCat("material_", index);
}

absl::StatusOr<MatteNames> ReadNames(const AssetSource& source) {
  GltfDocument document(source, ImportLimits());
  nlohmann::json json;
  std::string root;
  absl::string_view bin;
  bool has_bin = false;
  SL_RETURN_IF_ERROR(ReadGltfRoot(&document, &json, &root, &bin, &has_bin));
  const nlohmann::json none = nlohmann::json::array();
  const auto array = [&](const char* name) -> const nlohmann::json& {
    const auto found = json.find(name);
    return found == json.end() ? none : *found;
  };
  const nlohmann::json &nodes = array("nodes"), &meshes = array("meshes"), &materials = array("materials");
  MatteNames names;
  for (size_t n = 0; n < nodes.size(); ++n) {
    std::string& name = names.objects.emplace_back();
    const int64_t mesh = nodes[n].value("mesh", int64_t{-1});
    if (mesh < 0 || size_t(mesh) >= meshes.size()) continue;
    name = ObjectName(n, nodes[n].value("name", ""), meshes[size_t(mesh)].value("name", ""));
  }
  for (size_t m = 0; m <= materials.size(); ++m) {
    names.materials.push_back(MaterialName(
        m, materials.size(), m < materials.size() ? materials[m].value("name", "") : std::string()));
  }
  return names;
}

}  // namespace

MatteNames MatteNamesOf(const Scene& scene) {
  MatteNames names;
  for (size_t n = 0; n < scene.nodes.size(); ++n) {
    const Node& node = scene.nodes[n];
    std::string& name = names.objects.emplace_back();
    if (node.mesh >= 0) name = ObjectName(n, node.name, scene.meshes[size_t(node.mesh)].name);
  }
  for (size_t m = 0; m < scene.materials.size(); ++m) {
    names.materials.push_back(MaterialName(m, scene.materials.size() - 1, scene.materials[m].name));
  }
  return names;
}

absl::StatusOr<MatteNames> ReadMatteNames(const AssetSource& source) {
  const std::string context = absl::StrCat("read the names of scene ", source.RootName());
  try {
    absl::StatusOr<MatteNames> names = ReadNames(source);
    return names.ok() ? names : Annotate(names.status(), context);
  } catch (const std::exception& error) {
    return absl::InvalidArgumentError(absl::StrCat(context, ": ", error.what()));
  }
}

}  // namespace shutterline::engine
