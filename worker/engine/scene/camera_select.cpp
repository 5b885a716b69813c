#include "worker/engine/scene/camera_select.h"

#include <absl/strings/str_cat.h>

#include <optional>
#include <string>
#include <vector>

#include "common/base/status_macros.h"
#include "worker/engine/scene/animation_select.h"
#include "worker/engine/scene/pose.h"

namespace shutterline::engine {
namespace {

std::string ListCameras(const Scene& scene) {
  if (scene.cameras.empty()) return "it has none; leave the name empty for an automatic one";
  std::string list = "it has ";
  for (size_t i = 0; i < scene.cameras.size(); ++i) {
    absl::StrAppend(&list, i > 0 ? ", " : "", i, " \"", scene.cameras[i].name, "\"");
  }
  return list;
}

/// The camera's index that `name` means, other than through a node.
std::optional<int> CameraNamed(const Scene& scene, absl::string_view name) {
  for (size_t i = 0; i < scene.cameras.size(); ++i) {
    if (absl::string_view(scene.cameras[i].name) == name) return int(i);
  }
  return std::nullopt;
}

absl::StatusOr<CameraChoice> FindCamera(const Scene& scene, absl::string_view name) {
  std::vector<int> camera_nodes;
  for (const int node : NodesInDefaultScene(scene)) {
    if (scene.nodes[size_t(node)].camera >= 0) camera_nodes.push_back(node);
  }
  const auto camera_of = [&](int node) { return scene.nodes[size_t(node)].camera; };
  if (name.empty()) {
    if (camera_nodes.empty()) return CameraChoice{};
    return CameraChoice{camera_of(camera_nodes[0]), camera_nodes[0]};
  }
  std::optional<int> camera = CameraNamed(scene, name);
  if (!camera) {
    for (const int node : camera_nodes) {
      if (absl::string_view(scene.nodes[size_t(node)].name) == name)
        return CameraChoice{camera_of(node), node};
    }
    camera = ParseIndex(name, scene.cameras.size());
  }
  if (!camera) {
    return absl::InvalidArgumentError(
        absl::StrCat("scene ", scene.name, " has no camera \"", name, "\": ", ListCameras(scene)));
  }
  for (const int node : camera_nodes) {
    if (camera_of(node) == *camera) return CameraChoice{*camera, node};
  }
  return absl::InvalidArgumentError(absl::StrCat("scene ", scene.name, ": camera \"", name,
                                                 "\" is not placed by any node of the default scene"));
}

}  // namespace

absl::StatusOr<CameraChoice> SelectCamera(const Scene& scene, absl::string_view name) {
  SL_ASSIGN_OR_RETURN(const CameraChoice choice, FindCamera(scene, name));
  if (!choice.IsAutomatic()) {
    const Camera& camera = scene.cameras[size_t(choice.camera)];
    SL_RETURN_IF_ERROR(
        Annotate(MakeFrameView(camera, 1, 1).status(),
                 absl::StrCat("scene ", scene.name, ": camera ", choice.camera, " \"", camera.name, "\"")));
  }
  return choice;
}

}  // namespace shutterline::engine
