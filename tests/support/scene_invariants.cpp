#include "tests/support/scene_invariants.h"

#include <cmath>

#include "worker/engine/scene/material_textures.h"

namespace shutterline::engine {
namespace {

#define SL_HOLD(condition) \
  if (!(condition)) return #condition

bool In(int index, size_t size) {
  return index >= 0 && size_t(index) < size;
}
bool InOrNone(int index, size_t size) {
  return index == -1 || In(index, size);
}

template <typename Range>
bool AllFinite(const Range& values) {
  for (const auto& value : values) {
    if (!std::isfinite(value)) return false;
  }
  return true;
}

template <typename Vector>
bool Finite(const Vector& v) {
  for (unsigned i = 0; i < Vector::dimensions(); ++i) {
    if (!std::isfinite(v[int(i)])) return false;
  }
  return true;
}

template <typename Vector>
bool EmptyOrFinite(const std::vector<Vector>& values, size_t count) {
  for (const Vector& v : values) {
    if (!Finite(v)) return false;
  }
  return values.empty() || values.size() == count;
}

std::string BrokenIn(const Scene& scene, const MeshPrimitive& primitive) {
  const size_t count = primitive.positions.size();
  SL_HOLD(!primitive.triangles.empty());
  SL_HOLD(In(primitive.material, scene.materials.size()));
  SL_HOLD(EmptyOrFinite(primitive.normals, count));
  SL_HOLD(EmptyOrFinite(primitive.texcoords[0], count));
  SL_HOLD(EmptyOrFinite(primitive.texcoords[1], count));
  SL_HOLD(EmptyOrFinite(primitive.colors, count));
  SL_HOLD(EmptyOrFinite(primitive.tangents, 3 * primitive.triangles.size()));
  SL_HOLD(ShowsNormalTexture(scene.materials[size_t(primitive.material)], primitive) !=
          primitive.tangents.empty());
  for (const V4f& tangent : primitive.tangents) SL_HOLD(std::fabs(tangent.w) == 1);
  SL_HOLD(primitive.influences.empty() || primitive.influences.size() == count);
  for (const VertexInfluences& influences : primitive.influences) {
    SL_HOLD(AllFinite(influences.weights));
    double sum = 0;
    for (const float weight : influences.weights) sum += weight;
    SL_HOLD(std::fabs(sum - 1) < 1e-3);
  }
  for (const MorphTarget& target : primitive.targets) {
    SL_HOLD(target.positions.empty() || target.positions.size() == count);
    SL_HOLD(EmptyOrFinite(target.normals, count));
  }
  for (const auto& triangle : primitive.triangles) {
    for (const uint32_t v : triangle) {
      SL_HOLD(v < count);
      SL_HOLD(Finite(primitive.positions[v]));
      for (const MorphTarget& target : primitive.targets) {
        SL_HOLD(target.positions.empty() || Finite(target.positions[v]));
      }
    }
  }
  return "";
}

std::string BrokenIn(const Scene& scene, const Node& node) {
  SL_HOLD(InOrNone(node.parent, scene.nodes.size()));
  SL_HOLD(InOrNone(node.mesh, scene.meshes.size()));
  SL_HOLD(InOrNone(node.skin, scene.skins.size()));
  SL_HOLD(InOrNone(node.camera, scene.cameras.size()));
  SL_HOLD(InOrNone(node.light, scene.lights.size()));
  const int self = int(&node - scene.nodes.data());
  for (const int child : node.children) {
    SL_HOLD(In(child, scene.nodes.size()));
    SL_HOLD(scene.nodes[size_t(child)].parent == self);
  }
  SL_HOLD(AllFinite(node.weights));
  SL_HOLD(node.weights.empty() ||
          (node.mesh >= 0 && scene.meshes[size_t(node.mesh)].weights.size() == node.weights.size()));
  const NodeTransform& transform = node.transform;
  SL_HOLD(Finite(transform.translation) && Finite(transform.scale) && Finite(transform.rotation.v));
  const Quatd& q = transform.rotation;
  SL_HOLD(std::fabs(q.r * q.r + q.v.dot(q.v) - 1) < 1e-9);
  if (node.mesh < 0 || node.skin < 0) return "";
  const size_t joints = scene.skins[size_t(node.skin)].joints.size();
  for (const MeshPrimitive& primitive : scene.meshes[size_t(node.mesh)].primitives) {
    for (const VertexInfluences& influences : primitive.influences) {
      for (const uint16_t joint : influences.joints) SL_HOLD(joint < joints);
    }
  }
  return "";
}

std::string BrokenIn(const Scene& scene, const Material& material) {
  const auto is_unit = [](float value) { return value >= 0 && value <= 1; };
  for (int i = 0; i < 4; ++i) SL_HOLD(is_unit(material.base_color_factor[i]));
  SL_HOLD(is_unit(material.metallic_factor) && is_unit(material.roughness_factor));
  SL_HOLD(is_unit(material.occlusion_strength) && is_unit(material.specular_factor));
  SL_HOLD(std::isfinite(material.normal_scale) && std::isfinite(material.alpha_cutoff));
  SL_HOLD(material.ior == 0 || (material.ior >= 1 && std::isfinite(material.ior)));
  SL_HOLD(Finite(material.emissive_factor) && Finite(material.specular_color_factor));
  for (int i = 0; i < 3; ++i) {
    SL_HOLD(material.emissive_factor[i] >= 0 && material.specular_color_factor[i] >= 0);
  }
  for (const MaterialTexture& texture : TexturesOf(material)) {
    SL_HOLD(In(texture.reference->texture, scene.textures.size()));
    SL_HOLD(In(texture.reference->texcoord, 2));
    const TextureTransform& transform = texture.reference->transform;
    SL_HOLD(Finite(transform.offset) && Finite(transform.scale) && std::isfinite(transform.rotation));
  }
  return "";
}

std::string BrokenIn(const PunctualLight& light) {
  SL_HOLD(Finite(light.color) && std::isfinite(light.intensity) && std::isfinite(light.range));
  SL_HOLD(light.intensity >= 0 && light.range >= 0);
  for (int i = 0; i < 3; ++i) SL_HOLD(light.color[i] >= 0);
  SL_HOLD(light.inner_cone >= 0 && light.inner_cone <= light.outer_cone);
  SL_HOLD(light.outer_cone > 0 && light.outer_cone <= 1.5707964f);
  return "";
}

std::string BrokenIn(const Scene& scene, const AnimationChannel& channel) {
  SL_HOLD(In(channel.node, scene.nodes.size()));
  SL_HOLD(!channel.times.empty());
  SL_HOLD(AllFinite(channel.times) && AllFinite(channel.values));
  for (size_t i = 1; i < channel.times.size(); ++i) SL_HOLD(channel.times[i] > channel.times[i - 1]);
  const size_t per_key = channel.interpolation == Interpolation::kCubicSpline ? 3 : 1;
  SL_HOLD(channel.values.size() == channel.times.size() * size_t(channel.width) * per_key);
  return "";
}

}  // namespace

std::string BrokenSceneInvariant(const Scene& scene) {
  SL_HOLD(!scene.roots.empty());
  for (const int root : scene.roots) {
    SL_HOLD(In(root, scene.nodes.size()));
    SL_HOLD(scene.nodes[size_t(root)].parent == -1);
  }
  for (const Node& node : scene.nodes) {
    if (std::string broken = BrokenIn(scene, node); !broken.empty()) return broken;
  }
  for (const Mesh& mesh : scene.meshes) {
    SL_HOLD(AllFinite(mesh.weights));
    for (const MeshPrimitive& primitive : mesh.primitives) {
      SL_HOLD(primitive.targets.size() == mesh.weights.size());
      if (std::string broken = BrokenIn(scene, primitive); !broken.empty()) return broken;
    }
  }
  SL_HOLD(!scene.materials.empty());
  for (const Material& material : scene.materials) {
    if (std::string broken = BrokenIn(scene, material); !broken.empty()) return broken;
  }
  for (const PunctualLight& light : scene.lights) {
    if (std::string broken = BrokenIn(light); !broken.empty()) return broken;
  }
  for (const Texture& texture : scene.textures) SL_HOLD(In(texture.image, scene.images.size()));
  for (const TextureImage& image : scene.images) {
    SL_HOLD(image.width > 0 && image.height > 0);
    SL_HOLD(image.rgba.empty() != image.rgba16.empty());
    SL_HOLD(image.rgba.size() + image.rgba16.size() == size_t(image.width) * size_t(image.height) * 4);
  }
  for (const Skin& skin : scene.skins) {
    SL_HOLD(skin.inverse_bind_matrices.size() == skin.joints.size());
    for (const int joint : skin.joints) SL_HOLD(In(joint, scene.nodes.size()));
  }
  for (const Animation& animation : scene.animations) {
    for (const AnimationChannel& channel : animation.channels) {
      if (std::string broken = BrokenIn(scene, channel); !broken.empty()) return broken;
    }
  }
  return "";
}

#undef SL_HOLD

}  // namespace shutterline::engine
