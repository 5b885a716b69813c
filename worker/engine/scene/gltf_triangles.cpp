#include "worker/engine/scene/gltf_triangles.h"

#include "worker/engine/scene/gltf_tiny.h"

namespace shutterline::engine {

std::vector<std::array<uint32_t, 3>> CutGltfTriangles(int mode, const std::vector<uint32_t>& v) {
  const size_t count = CountGltfTriangles(mode, v.size());
  std::vector<std::array<uint32_t, 3>> triangles;
  triangles.reserve(count);
  for (size_t i = 0; i < count; ++i) {
    switch (mode) {
      case TINYGLTF_MODE_TRIANGLES:
        triangles.push_back({v[3 * i], v[3 * i + 1], v[3 * i + 2]});
        break;
      case TINYGLTF_MODE_TRIANGLE_STRIP:
        // Every other triangle of a strip is taken backwards, so that all face the same way.
        triangles.push_back({v[i], v[i + 1 + i % 2], v[i + 2 - i % 2]});
        break;
      default:
        triangles.push_back({v[i + 1], v[i + 2], v[0]});
        break;
    }
  }
  return triangles;
}

uint64_t CountGltfTriangles(int mode, uint64_t count) {
  if (mode == TINYGLTF_MODE_TRIANGLES) return count / 3;
  if (mode == TINYGLTF_MODE_TRIANGLE_STRIP || mode == TINYGLTF_MODE_TRIANGLE_FAN)
    return count < 3 ? 0 : count - 2;
  return 0;
}

uint64_t CountGltfLines(int mode, uint64_t count) {
  if (count < 2) return 0;
  if (mode == TINYGLTF_MODE_LINE) return count / 2;
  if (mode == TINYGLTF_MODE_LINE_LOOP) return count;
  if (mode == TINYGLTF_MODE_LINE_STRIP) return count - 1;
  return 0;
}

}  // namespace shutterline::engine
