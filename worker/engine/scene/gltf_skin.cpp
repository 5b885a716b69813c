#include "worker/engine/scene/gltf_skin.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <cmath>

#include "common/base/status_macros.h"
#include "common/base/work_limit.h"
#include "worker/engine/scene/gltf_accessor.h"

namespace shutterline::engine {
namespace {

absl::Status ReadInverseBindMatrices(GltfDocument* document, int accessor, Skin* skin) {
  const absl::string_view role = "inverseBindMatrices";
  SL_RETURN_IF_ERROR(CheckGltfAccessorType(*document, accessor, {role, {TINYGLTF_TYPE_MAT4}}));
  const uint64_t count = document->model.accessors[size_t(accessor)].count;
  const std::string element = GltfAccessorElement(accessor, role);
  if (count < skin->joints.size()) {
    return absl::InvalidArgumentError(
        absl::StrCat(element, ": ", count, " matrices for ", skin->joints.size(), " joints"));
  }
  SL_RETURN_IF_ERROR(document->memory.Take(count * 16 * (sizeof(float) + sizeof(double)), element));
  std::vector<float> values(count * 16);
  SL_RETURN_IF_ERROR(ReadGltfFloats(*document, accessor, values.data()));
  for (size_t j = 0; j < skin->joints.size(); ++j) {
    for (size_t i = 0; i < 16; ++i) {
      const float value = values[16 * j + i];
      if (!std::isfinite(value))
        return absl::InvalidArgumentError(absl::StrCat(element, ": matrix ", j, " is not finite"));
      // The same sequence of numbers for column and for row vectors, see gltf_nodes.cpp.
      skin->inverse_bind_matrices[j].x[i / 4][i % 4] = value;
    }
  }
  return absl::OkStatus();
}

absl::Status ReadSkin(GltfDocument* document, const tinygltf::Skin& in, Skin* skin) {
  skin->name = in.name;
  skin->joints = in.joints;
  if (skin->joints.empty()) return absl::InvalidArgumentError("it has no joints");
  SL_RETURN_IF_ERROR(document->memory.Take(skin->joints.size() * sizeof(M44d), "joints"));
  skin->inverse_bind_matrices.resize(skin->joints.size());
  if (in.inverseBindMatrices < 0) return absl::OkStatus();
  return ReadInverseBindMatrices(document, in.inverseBindMatrices, skin);
}

/// The largest joint that a vertex of the mesh names, -1 where none does.
int LargestJoint(const Mesh& mesh) {
  int largest = -1;
  for (const MeshPrimitive& primitive : mesh.primitives) {
    for (const VertexInfluences& influences : primitive.influences) {
      largest = std::max<int>(largest, *std::max_element(influences.joints.begin(), influences.joints.end()));
    }
  }
  return largest;
}

}  // namespace

absl::Status ImportGltfSkins(GltfDocument* document, Scene* scene) {
  for (size_t s = 0; s < document->model.skins.size(); ++s) {
    CheckWork();
    const tinygltf::Skin& in = document->model.skins[s];
    Skin skin;
    SL_RETURN_IF_ERROR(Annotate(ReadSkin(document, in, &skin), GltfElement("skin", s, in.name)));
    scene->skins.push_back(std::move(skin));
  }

  std::vector<int> largest;
  largest.reserve(scene->meshes.size());
  for (const Mesh& mesh : scene->meshes) largest.push_back(LargestJoint(mesh));
  for (size_t n = 0; n < scene->nodes.size(); ++n) {
    const Node& node = scene->nodes[n];
    if (node.mesh < 0 || node.skin < 0) continue;
    const int joint = largest[size_t(node.mesh)];
    const size_t joints = scene->skins[size_t(node.skin)].joints.size();
    if (joint >= 0 && size_t(joint) >= joints) {
      return absl::InvalidArgumentError(absl::StrCat(GltfElement("node", n, node.name), ": mesh ", node.mesh,
                                                     " uses joint ", joint, ", but skin ", node.skin, " has ",
                                                     joints));
    }
    if (joint < 0 && !scene->meshes[size_t(node.mesh)].primitives.empty()) {
      document->Warn(
          absl::StrCat(GltfElement("node", n, node.name), ": it has a skin, but its mesh has no joints"));
    }
  }
  return absl::OkStatus();
}

}  // namespace shutterline::engine
