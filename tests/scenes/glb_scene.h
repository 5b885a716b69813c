#pragma once

#include <ImathQuat.h>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "common/math/spaces.h"

/// What a generated scene is made of: the part of glTF 2.0 that generators use, as plain data. Lengths in
/// metres, times in seconds, colours linear; indices of -1 mean none.
namespace shutterline::scenes {

struct Material {
  std::string name;
  V3f color{1, 1, 1};
  bool unlit = true;
  bool double_sided = false;
};

/// Triangles of one material, counter-clockwise seen from the front.
struct Primitive {
  int material = 0;
  std::vector<V3f> positions;
  std::vector<V3f> normals;        ///< Empty, or one a position.
  std::vector<V3f> colors;         ///< COLOR_0: empty, or one a position.
  std::vector<V3f> morph_offsets;  ///< Morph target 0: empty, or one a position.
  std::vector<std::array<uint32_t, 3>> triangles;
};

/// Either all primitives of a mesh have a morph target, or none.
struct Mesh {
  std::string name;
  std::vector<Primitive> primitives;
};

struct Node {
  std::string name;
  V3f translation{0, 0, 0};
  Imath::Quatf rotation;  ///< Identity unless set; unit.
  float scale = 1;
  int mesh = -1;
  int camera = -1;
  std::vector<int> children;
};

enum class Path { kTranslation, kRotation, kWeights };

/// LINEAR keys of one property. A key's values: 3 (translation), 4 (rotation: x, y, z, w) or 1 (weights).
struct Channel {
  int node = 0;
  Path path = Path::kTranslation;
  std::vector<float> times;
  std::vector<float> values;
};

struct Camera {
  double yfov = 0.7;  ///< Radians.
  double aspect_ratio = 4.0 / 3;
  double znear = 0.01;
};

struct GlbScene {
  std::string name;
  std::vector<Material> materials;
  std::vector<Mesh> meshes;
  std::vector<Node> nodes;
  std::vector<Camera> cameras;
  std::vector<Channel> channels;  ///< Of one animation; none: the scene stands still.

  int Add(Material material) { return Append(materials, std::move(material)); }
  int Add(Mesh mesh) { return Append(meshes, std::move(mesh)); }
  int Add(Node node) { return Append(nodes, std::move(node)); }
  int Add(Camera camera) { return Append(cameras, camera); }

  /// Triangles that the scene draws: an instanced mesh counts once for each node.
  int64_t DrawnTriangles() const {
    int64_t count = 0;
    for (const Node& node : nodes) {
      if (node.mesh < 0) continue;
      for (const Primitive& primitive : meshes[size_t(node.mesh)].primitives) {
        count += int64_t(primitive.triangles.size());
      }
    }
    return count;
  }

 private:
  template <typename T>
  static int Append(std::vector<T>& list, T value) {
    list.push_back(std::move(value));
    return int(list.size()) - 1;
  }
};

}  // namespace shutterline::scenes
