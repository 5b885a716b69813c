#include "worker/engine/scene/gltf_tangents.h"

#include "common/base/status_macros.h"
#include "common/base/work_limit.h"
#include "worker/engine/scene/material_textures.h"
#include "worker/engine/scene/tangent_space.h"

namespace shutterline::engine {
namespace {

/// What making them takes for a while besides: keys, numbers and sums of vertices.
constexpr uint64_t kWorkBytesPerVertex = 96;

}  // namespace

absl::Status ImportGltfTangents(GltfDocument* document, Scene* scene) {
  for (size_t m = 0; m < scene->meshes.size(); ++m) {
    Mesh& mesh = scene->meshes[m];
    for (MeshPrimitive& primitive : mesh.primitives) {
      CheckWork();
      const Material& material = scene->materials[size_t(primitive.material)];
      if (!ShowsNormalTexture(material, primitive)) {
        primitive.tangents = {};
        continue;
      }
      if (!primitive.tangents.empty()) continue;
      const uint64_t bytes =
          3 * sizeof(V4f) * primitive.triangles.size() + kWorkBytesPerVertex * primitive.positions.size();
      SL_RETURN_IF_ERROR(
          Annotate(document->memory.Take(bytes, "tangents"), GltfElement("mesh", m, mesh.name)));
      primitive.tangents = MakeTangents(primitive, material.normal_texture.texcoord);
    }
  }
  return absl::OkStatus();
}

}  // namespace shutterline::engine
