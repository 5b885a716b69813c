#include "worker/engine/scene/gltf_mesh.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <numeric>
#include <set>
#include <tuple>

#include "common/base/status_macros.h"
#include "common/base/work_limit.h"
#include "worker/engine/scene/gltf_accessor.h"
#include "worker/engine/scene/gltf_triangles.h"
#include "worker/engine/scene/gltf_vertices.h"

namespace shutterline::engine {
namespace {

class MeshImporter {
 public:
  MeshImporter(GltfDocument* document, Scene* scene) : document_(*document), scene_(*scene) {}

  absl::Status ImportAll() {
    for (size_t m = 0; m < document_.model.meshes.size(); ++m) {
      const std::string element = GltfElement("mesh", m, document_.model.meshes[m].name);
      SL_RETURN_IF_ERROR(Annotate(ImportMesh(document_.model.meshes[m], element), element));
    }
    return absl::OkStatus();
  }

 private:
  absl::Status ImportMesh(const tinygltf::Mesh& in, const std::string& element) {
    Mesh mesh;
    mesh.name = in.name;
    const size_t targets = in.primitives.empty() ? 0 : in.primitives[0].targets.size();
    for (size_t p = 0; p < in.primitives.size(); ++p) {
      CheckWork();
      if (in.primitives[p].targets.size() != targets) {
        return absl::InvalidArgumentError(absl::StrCat("primitive ", p, ": ", in.primitives[p].targets.size(),
                                                       " morph targets, but primitive 0 has ", targets));
      }
      MeshPrimitive primitive;
      SL_RETURN_IF_ERROR(
          Annotate(ImportPrimitive(in.primitives[p], absl::StrCat(element, " primitive ", p), &primitive),
                   absl::StrCat("primitive ", p)));
      if (!primitive.triangles.empty()) mesh.primitives.push_back(std::move(primitive));
    }
    if (!in.weights.empty() && in.weights.size() != targets) {
      return absl::InvalidArgumentError(
          absl::StrCat("weights: ", in.weights.size(), " of them for ", targets, " morph targets"));
    }
    mesh.weights.assign(in.weights.begin(), in.weights.end());
    mesh.weights.resize(targets, 0.0f);
    scene_.meshes.push_back(std::move(mesh));
    return absl::OkStatus();
  }

  /// Leaves `out` without triangles where there is nothing to draw.
  absl::Status ImportPrimitive(const tinygltf::Primitive& in, const std::string& element,
                               MeshPrimitive* out) {
    const auto position = in.attributes.find("POSITION");
    if (position == in.attributes.end()) {
      document_.Warn(absl::StrCat(element, ": no POSITION, nothing to draw"));
      return absl::OkStatus();
    }
    SL_RETURN_IF_ERROR(CheckGltfPrimitive(document_, in));
    const uint64_t vertex_count = document_.model.accessors[size_t(position->second)].count;
    const uint64_t corner_count =
        in.indices >= 0 ? uint64_t{document_.model.accessors[size_t(in.indices)].count} : vertex_count;
    // Points and lines draw nothing yet, so only their indices are looked at.
    const uint64_t triangle_count = CountGltfTriangles(in.mode, corner_count);
    SL_RETURN_IF_ERROR(document_.vertices.Take(std::max(vertex_count, corner_count), "vertices"));
    SL_RETURN_IF_ERROR(document_.triangles.Take(triangle_count, "triangles"));
    SL_RETURN_IF_ERROR(document_.memory.Take(
        corner_count * sizeof(uint32_t) + triangle_count * sizeof(out->triangles[0]), "triangles"));
    SL_ASSIGN_OR_RETURN(const std::vector<uint32_t> corners, ReadCorners(in, corner_count, vertex_count));
    if (in.mode == TINYGLTF_MODE_POINTS) document_.report.skipped_points += int64_t(corner_count);
    document_.report.skipped_lines += int64_t(CountGltfLines(in.mode, corner_count));
    if (in.mode == TINYGLTF_MODE_TRIANGLES && corner_count % 3 != 0) {
      document_.Warn(absl::StrCat(element, ": the last ", corner_count % 3, " corners make no triangle"));
    }
    if (triangle_count == 0) return absl::OkStatus();

    std::vector<bool> finite;
    SL_RETURN_IF_ERROR(ReadGltfVertices(&document_, in, element, out, &finite));
    out->triangles = CutGltfTriangles(in.mode, corners);
    DropTrianglesWithoutPlace(finite, element, out);
    if (NeedsTangents(in)) SL_RETURN_IF_ERROR(ReadGltfTangents(&document_, in, element, out));
    out->material = in.material >= 0 ? in.material : int(document_.model.materials.size());
    if (seen_.emplace(position->second, in.indices, in.mode).second) {
      document_.report.stored_triangles += int64_t(out->triangles.size());
    }
    return absl::OkStatus();
  }

  /// Asked of the file's material, as materials are imported later.
  bool NeedsTangents(const tinygltf::Primitive& in) const {
    if (in.material < 0) return false;
    const tinygltf::Material& material = document_.model.materials[size_t(in.material)];
    return material.normalTexture.index >= 0 && material.extensions.count("KHR_materials_unlit") == 0;
  }

  absl::StatusOr<std::vector<uint32_t>> ReadCorners(const tinygltf::Primitive& in, uint64_t corner_count,
                                                    uint64_t vertex_count) const {
    std::vector<uint32_t> corners(corner_count);
    if (in.indices < 0) {
      std::iota(corners.begin(), corners.end(), 0u);
      return corners;
    }
    SL_RETURN_IF_ERROR(ReadGltfUints(document_, in.indices, corners.data()));
    for (size_t i = 0; i < corners.size(); ++i) {
      if (corners[i] >= vertex_count) {
        return absl::InvalidArgumentError(absl::StrCat(GltfAccessorElement(in.indices, "indices"), ": index ",
                                                       i, " is ", corners[i], ", but there are ",
                                                       vertex_count, " vertices"));
      }
    }
    return corners;
  }

  void DropTrianglesWithoutPlace(const std::vector<bool>& finite, const std::string& element,
                                 MeshPrimitive* out) {
    const auto bad = std::find(finite.begin(), finite.end(), false);
    if (bad == finite.end()) return;
    const auto gone = std::remove_if(out->triangles.begin(), out->triangles.end(), [&](const auto& triangle) {
      return !finite[triangle[0]] || !finite[triangle[1]] || !finite[triangle[2]];
    });
    const auto dropped = out->triangles.end() - gone;
    out->triangles.erase(gone, out->triangles.end());
    document_.report.dropped_triangles += dropped;
    document_.Warn(absl::StrCat(element, ": ", std::count(finite.begin(), finite.end(), false),
                                " vertices, the first of them ", bad - finite.begin(),
                                ", are not finite: ", dropped, " triangles dropped"));
  }

  GltfDocument& document_;
  Scene& scene_;
  std::set<std::tuple<int, int, int>> seen_;  ///< What shares its triangles: POSITION, indices, mode.
};

}  // namespace

absl::Status ImportGltfMeshes(GltfDocument* document, Scene* scene) {
  return MeshImporter(document, scene).ImportAll();
}

}  // namespace shutterline::engine
