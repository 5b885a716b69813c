#include "worker/engine/scene/gltf_import.h"

#include <absl/status/status.h>
#include <absl/strings/str_cat.h>

#include <algorithm>
#include <new>
#include <nlohmann/json.hpp>

#include "common/base/status_macros.h"
#include "common/base/work_limit.h"
#include "worker/engine/scene/gltf_animation.h"
#include "worker/engine/scene/gltf_camera.h"
#include "worker/engine/scene/gltf_document.h"
#include "worker/engine/scene/gltf_material.h"
#include "worker/engine/scene/gltf_mesh.h"
#include "worker/engine/scene/gltf_nodes.h"
#include "worker/engine/scene/gltf_skin.h"
#include "worker/engine/scene/gltf_tangents.h"
#include "worker/engine/scene/gltf_uri.h"

namespace shutterline::engine {
namespace {

/// A scene without a triangle would be rendered as an empty picture and look like a success.
absl::Status CheckThatSomethingIsDrawn(const GltfDocument& document, const Scene& scene) {
  if (document.model.scenes.empty())
    return absl::InvalidArgumentError("nothing to draw: the file has no scene");
  std::vector<int> open = scene.roots;
  while (!open.empty()) {
    const Node& node = scene.nodes[size_t(open.back())];
    open.pop_back();
    if (node.mesh >= 0 && !scene.meshes[size_t(node.mesh)].primitives.empty()) return absl::OkStatus();
    open.insert(open.end(), node.children.begin(), node.children.end());
  }
  const ImportReport& report = document.report;
  return absl::InvalidArgumentError(absl::StrCat(
      "nothing to draw: the default scene has no triangles (", report.skipped_points, " points and ",
      report.skipped_lines, " lines skipped, ", report.dropped_triangles, " triangles dropped)"));
}

absl::Status ImportAll(const AssetSource& source, const ImportLimits& limits, Scene* scene) {
  GltfDocument document(source, limits);
  scene->name = source.RootName();
  SL_RETURN_IF_ERROR(LoadGltfDocument(&document));
  SL_RETURN_IF_ERROR(ImportGltfMeshes(&document, scene));
  SL_RETURN_IF_ERROR(ImportGltfNodes(&document, scene));
  SL_RETURN_IF_ERROR(ImportGltfSkins(&document, scene));
  SL_RETURN_IF_ERROR(ImportGltfCameras(&document, scene));
  SL_RETURN_IF_ERROR(ImportGltfAnimations(&document, scene));
  SL_RETURN_IF_ERROR(CheckThatSomethingIsDrawn(document, *scene));
  SL_RETURN_IF_ERROR(ImportGltfMaterials(&document, scene));
  SL_RETURN_IF_ERROR(ImportGltfTangents(&document, scene));
  scene->lights = std::move(document.lights);
  document.CloseWarnings();
  scene->report = std::move(document.report);
  return absl::OkStatus();
}

absl::StatusOr<std::vector<std::string>> ListAll(const AssetSource& source, absl::string_view root,
                                                 const ImportLimits& limits) {
  GltfDocument document(source, limits);
  nlohmann::json json;
  absl::string_view bin;
  bool has_bin = false;
  SL_RETURN_IF_ERROR(ParseGltfRoot(&document, root, &json, &bin, &has_bin));
  std::vector<std::string> files;
  for (const char* array : {"buffers", "images"}) {
    const auto elements = json.find(array);
    if (elements == json.end()) continue;
    for (size_t i = 0; i < elements->size(); ++i) {
      const std::string uri = (*elements)[i].value("uri", "");
      if (uri.empty() || IsDataUri(uri)) continue;
      absl::StatusOr<std::string> name = DecodeFileUri(uri);
      if (!name.ok()) {
        return Annotate(name.status(), absl::StrCat(array[0] == 'b' ? "buffer " : "image ", i));
      }
      if (std::find(files.begin(), files.end(), *name) == files.end()) files.push_back(*std::move(name));
    }
  }
  return files;
}

/// Runs `work`, turns exceptions of libraries into statuses and says which scene it was about.
template <typename Work>
auto Guard(const AssetSource& source, const Work& work) -> decltype(work()) {
  const std::string context = absl::StrCat("load scene ", source.RootName());
  try {
    auto result = work();
    if (result.ok()) return result;
    return Annotate(result.status(), context);
  } catch (const WorkLimit::Exceeded& exceeded) {
    return TookTooLong(context, exceeded);
  } catch (const std::bad_alloc&) {
    return absl::ResourceExhaustedError(absl::StrCat(context, ": out of memory"));
  } catch (const std::exception& error) {
    return absl::InvalidArgumentError(absl::StrCat(context, ": ", error.what()));
  }
}

}  // namespace

absl::StatusOr<std::shared_ptr<const Scene>> ImportGltf(const AssetSource& source,
                                                        const ImportLimits& limits) {
  return Guard(source, [&]() -> absl::StatusOr<std::shared_ptr<const Scene>> {
    auto scene = std::make_shared<Scene>();
    SL_RETURN_IF_ERROR(ImportAll(source, limits, scene.get()));
    SL_ASSIGN_OR_RETURN(scene->environment, ReadEnvironment(source, limits.max_file_bytes));
    return std::shared_ptr<const Scene>(std::move(scene));
  });
}

absl::StatusOr<std::vector<std::string>> ListExternalFiles(const AssetSource& source, absl::string_view root,
                                                           const ImportLimits& limits) {
  return Guard(source, [&] { return ListAll(source, root, limits); });
}

}  // namespace shutterline::engine
