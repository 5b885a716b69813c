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

/// A picture in the file, and how a material uses it.
struct Image {
  std::string name;
  std::string png;  ///< EncodePng, png_picture.h.
};
struct TextureUse {
  int image = -1;
  V2f offset{0, 0}, scale{1, 1};  ///< KHR_texture_transform.
  float rotation = 0;
};

enum class AlphaMode { kOpaque, kMask, kBlend };

struct Material {
  std::string name;
  V3f color{1, 1, 1};
  bool unlit = true;
  bool double_sided = false;
  // Of those that are not unlit; alpha is of all.
  float alpha = 1;
  AlphaMode alpha_mode = AlphaMode::kOpaque;
  float alpha_cutoff = 0.5f;
  float metallic = 0, roughness = 1;
  float normal_scale = 1, occlusion_strength = 1;
  V3f emission{0, 0, 0};  ///< May exceed 1: KHR_materials_emissive_strength.
  float ior = 1.5f;       ///< KHR_materials_ior.
  float specular = 1;     ///< KHR_materials_specular.
  V3f specular_color{1, 1, 1};
  TextureUse color_texture, metallic_roughness_texture, normal_texture, occlusion_texture, emission_texture;
};

/// KHR_lights_punctual; shines along its node's -z axis.
struct Light {
  enum class Kind { kDirectional, kPoint, kSpot };
  Kind kind = Kind::kPoint;
  V3f color{1, 1, 1};
  float intensity = 1;  ///< Lux or candela.
  float range = 0;      ///< 0: infinite.
  float inner_cone = 0, outer_cone = 0.7853982f;
};

/// Triangles of one material, counter-clockwise seen from the front.
struct Primitive {
  int material = 0;
  std::vector<V3f> positions;
  std::vector<V3f> normals;        ///< Empty, or one a position.
  std::vector<V3f> colors;         ///< COLOR_0: empty, or one a position.
  std::vector<V2f> texcoords;      ///< TEXCOORD_0: empty, or one a position.
  std::vector<V4f> tangents;       ///< Empty, or one a position.
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
  int light = -1;
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
  std::vector<Image> images;
  std::vector<Material> materials;
  std::vector<Mesh> meshes;
  std::vector<Node> nodes;
  std::vector<Camera> cameras;
  std::vector<Light> lights;
  std::vector<Channel> channels;  ///< Of one animation; none: the scene stands still.

  int Add(Image image) { return Append(images, std::move(image)); }
  int Add(Light light) { return Append(lights, light); }
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
