#include "worker/engine/scene/gltf_nodes.h"

#include <absl/strings/str_cat.h>

#include <utility>

#include "common/base/status_macros.h"
#include "common/base/work_limit.h"
#include "worker/engine/scene/pose.h"

namespace shutterline::engine {
namespace {

/// The quaternion of unit length along q, in double: files hold it in single precision at best. A zero
/// quaternion, which turns nowhere, becomes the identity; returns false then.
bool NormalizeRotation(const std::vector<double>& q, Quatd* out) {
  *out = Quatd();
  if (q.size() != 4) return true;
  const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  if (!(length > 1e-30)) return false;
  *out = Quatd(q[3] / length, V3d(q[0] / length, q[1] / length, q[2] / length));
  return true;
}

NodeTransform ReadTransform(const tinygltf::Node& in, bool* rotation_is_zero) {
  NodeTransform transform;
  if (in.matrix.size() == 16) {
    // glTF: column vectors, columns first in memory. Imath: row vectors, rows first. The same sequence.
    transform.has_matrix = true;
    for (int i = 0; i < 16; ++i) transform.matrix.x[i / 4][i % 4] = in.matrix[size_t(i)];
    return transform;
  }
  if (in.translation.size() == 3)
    transform.translation = V3d(in.translation[0], in.translation[1], in.translation[2]);
  if (in.scale.size() == 3) transform.scale = V3d(in.scale[0], in.scale[1], in.scale[2]);
  *rotation_is_zero = !NormalizeRotation(in.rotation, &transform.rotation);
  return transform;
}

absl::Status ReadNode(GltfDocument* document, const Scene& scene, const tinygltf::Node& in,
                      const std::string& element, Node* node) {
  node->name = in.name;
  node->children = in.children;
  node->mesh = in.mesh;
  node->skin = in.skin;
  node->camera = in.camera;
  if (const auto light = in.extensions.find("KHR_lights_punctual"); light != in.extensions.end()) {
    node->light = light->second.Get("light").GetNumberAsInt();
  }
  bool rotation_is_zero = false;
  node->transform = ReadTransform(in, &rotation_is_zero);
  if (rotation_is_zero) document->Warn(absl::StrCat(element, ": a rotation of length 0 taken as none"));
  node->weights.assign(in.weights.begin(), in.weights.end());
  if (node->weights.empty()) return absl::OkStatus();
  const size_t targets = in.mesh >= 0 ? scene.meshes[size_t(in.mesh)].weights.size() : 0;
  if (node->weights.size() != targets) {
    return absl::InvalidArgumentError(
        absl::StrCat("weights: ", node->weights.size(), " of them for ", targets, " morph targets"));
  }
  return absl::OkStatus();
}

absl::Status LinkParents(std::vector<Node>* nodes) {
  for (size_t n = 0; n < nodes->size(); ++n) {
    for (const int child : (*nodes)[n].children) {
      Node& node = (*nodes)[size_t(child)];
      if (size_t(child) == n)
        return absl::InvalidArgumentError(absl::StrCat("node ", n, ": it is its own child"));
      if (node.parent >= 0) {
        return absl::InvalidArgumentError(
            absl::StrCat("node ", child, ": it has two parents, nodes ", node.parent, " and ", n));
      }
      node.parent = int(n);
    }
  }
  return absl::OkStatus();
}

/// Walks down from the nodes without parents. With one parent each at most, what is not met lies on a
/// cycle or below one.
absl::Status CheckForest(const std::vector<Node>& nodes, uint32_t max_depth) {
  std::vector<std::pair<int, uint32_t>> open;  // Node, depth.
  std::vector<bool> met(nodes.size(), false);
  for (size_t n = 0; n < nodes.size(); ++n) {
    if (nodes[n].parent < 0) open.emplace_back(int(n), 1u);
  }
  while (!open.empty()) {
    const auto [n, depth] = open.back();
    open.pop_back();
    if (depth > max_depth) {
      return absl::ResourceExhaustedError(
          absl::StrCat("node ", n, ": nested deeper than the limit of ", max_depth));
    }
    met[size_t(n)] = true;
    for (const int child : nodes[size_t(n)].children) open.emplace_back(child, depth + 1);
  }
  for (size_t n = 0; n < nodes.size(); ++n) {
    if (!met[n]) return absl::InvalidArgumentError(absl::StrCat("node ", n, ": its ancestors form a cycle"));
  }
  return absl::OkStatus();
}

absl::Status ReadRoots(const GltfDocument& document, Scene* scene) {
  const tinygltf::Model& model = document.model;
  if (model.scenes.empty()) return absl::OkStatus();
  const size_t index = model.defaultScene >= 0 ? size_t(model.defaultScene) : 0;
  std::vector<bool> listed(scene->nodes.size(), false);
  for (const int root : model.scenes[index].nodes) {
    if (listed[size_t(root)]) {
      return absl::InvalidArgumentError(absl::StrCat("scene ", index, ": it lists node ", root, " twice"));
    }
    listed[size_t(root)] = true;
    if (const int parent = scene->nodes[size_t(root)].parent; parent >= 0) {
      return absl::InvalidArgumentError(
          absl::StrCat("scene ", index, ": node ", root, " is not a root, its parent is node ", parent));
    }
    scene->roots.push_back(root);
  }
  return absl::OkStatus();
}

/// A frame stores every mesh as often as it is drawn, so a few nodes and one mesh could ask for more than any
/// machine has.
absl::Status CheckDrawn(GltfDocument* document, const Scene& scene) {
  for (const int n : NodesInDefaultScene(scene)) {
    CheckWork();
    const Node& node = scene.nodes[size_t(n)];
    if (node.mesh < 0) continue;
    const std::string element = GltfElement("node", size_t(n), node.name);
    const size_t joints = node.skin < 0 ? 0 : document->model.skins[size_t(node.skin)].joints.size();
    SL_RETURN_IF_ERROR(
        document->posed.Take(joints + scene.meshes[size_t(node.mesh)].weights.size(), element));
    for (const MeshPrimitive& primitive : scene.meshes[size_t(node.mesh)].primitives) {
      SL_RETURN_IF_ERROR(document->drawn_triangles.Take(primitive.triangles.size(), element));
      SL_RETURN_IF_ERROR(document->drawn_vertices.Take(primitive.positions.size(), element));
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status ImportGltfNodes(GltfDocument* document, Scene* scene) {
  for (size_t n = 0; n < document->model.nodes.size(); ++n) {
    CheckWork();
    const tinygltf::Node& in = document->model.nodes[n];
    const std::string element = GltfElement("node", n, in.name);
    Node node;
    SL_RETURN_IF_ERROR(Annotate(ReadNode(document, *scene, in, element, &node), element));
    scene->nodes.push_back(std::move(node));
  }
  SL_RETURN_IF_ERROR(LinkParents(&scene->nodes));
  SL_RETURN_IF_ERROR(CheckForest(scene->nodes, document->limits.max_depth));
  SL_RETURN_IF_ERROR(ReadRoots(*document, scene));
  return CheckDrawn(document, *scene);
}

}  // namespace shutterline::engine
