#include "worker/engine/scene/scene_info.h"

#include <absl/strings/str_cat.h>
#include <absl/strings/str_format.h>

#include <algorithm>
#include <cmath>

#include "worker/engine/scene/camera_pose.h"
#include "worker/engine/scene/material_textures.h"
#include "worker/engine/scene/mesh_pose.h"
#include "worker/engine/scene/pose.h"
#include "worker/engine/scene/scene_bounds.h"

namespace shutterline::engine {
namespace {

SceneInfo::AnimationInfo DescribeAnimation(const Animation& animation) {
  SceneInfo::AnimationInfo info;
  info.name = animation.name;
  for (const AnimationChannel& channel : animation.channels) {
    if (channel.times.empty()) continue;
    const double first = channel.times.front(), last = channel.times.back();
    info.first_key_seconds = info.channels == 0 ? first : std::min(info.first_key_seconds, first);
    info.last_key_seconds = info.channels == 0 ? last : std::max(info.last_key_seconds, last);
    ++info.channels;
    info.keys += int64_t(channel.times.size());
    switch (channel.interpolation) {
      case Interpolation::kStep:
        ++info.step;
        break;
      case Interpolation::kLinear:
        ++info.linear;
        break;
      case Interpolation::kCubicSpline:
        ++info.cubic_spline;
        break;
    }
    switch (channel.path) {
      case AnimatedPath::kTranslation:
        ++info.translation;
        break;
      case AnimatedPath::kRotation:
        ++info.rotation;
        break;
      case AnimatedPath::kScale:
        ++info.scale;
        break;
      case AnimatedPath::kWeights:
        ++info.morph_weights;
        break;
    }
  }
  return info;
}

/// What a material uses, in the words of SceneInfo::materials_with.
std::vector<std::string> UsesOf(const Material& material) {
  std::vector<std::string> uses;
  const auto note = [&](bool used, const char* what) {
    if (used) uses.emplace_back(what);
  };
  note(material.unlit, "unlit");
  note(material.double_sided, "double sides");
  note(material.alpha_mode == AlphaMode::kMask, "alpha mask");
  note(material.alpha_mode == AlphaMode::kBlend, "alpha blend");
  note(material.emissive_factor != V3f(0), "emission");
  bool transformed = false;
  for (const MaterialTexture& texture : TexturesOf(material)) {
    uses.push_back(absl::StrCat(texture.role, " texture"));
    transformed = transformed || !texture.reference->transform.IsIdentity();
  }
  note(transformed, "texture transform");
  return uses;
}

void CountStored(const Scene& scene, SceneInfo& info) {
  info.nodes = int64_t(scene.nodes.size());
  info.meshes = int64_t(scene.meshes.size());
  for (const Mesh& mesh : scene.meshes) {
    size_t targets = 0;
    for (const MeshPrimitive& primitive : mesh.primitives) {
      ++info.mesh_primitives;
      info.vertices += int64_t(primitive.positions.size());
      info.stored_triangles += int64_t(primitive.triangles.size());
      targets = std::max(targets, primitive.targets.size());
    }
    info.morph_targets += int64_t(targets);
  }
  // The importer knows which primitives share their triangles.
  if (scene.report.stored_triangles > 0) info.stored_triangles = scene.report.stored_triangles;
  info.materials = std::max<int64_t>(0, int64_t(scene.materials.size()) - 1);
  info.textures = int64_t(scene.textures.size());
  for (const TextureImage& image : scene.images) {
    info.texture_pixels += int64_t{image.width} * image.height;
    info.images.push_back({image.name, image.width, image.height, image.rgba16.empty() ? 8 : 16});
  }
  for (size_t m = 0; m < size_t(info.materials); ++m) {
    for (const std::string& use : UsesOf(scene.materials[m])) ++info.materials_with[use];
  }
  for (const PunctualLight& light : scene.lights) info.lights.push_back({light.name, light.kind, 0});
  for (const Camera& camera : scene.cameras) info.cameras.push_back({camera.name, camera.perspective, -1});
  for (const Animation& animation : scene.animations) info.animations.push_back(DescribeAnimation(animation));
  for (const Skin& skin : scene.skins) info.skins.push_back({skin.name, int64_t(skin.joints.size())});
}

}  // namespace

SceneInfo DescribeScene(const Scene& scene) {
  SceneInfo info;
  info.name = scene.name;
  info.import = scene.report;
  CountStored(scene, info);

  const Pose rest = PoseSampler(scene, {}).At(0);
  const std::vector<int> nodes = NodesInDefaultScene(scene);
  info.scene_nodes = int64_t(nodes.size());
  std::vector<int> mesh_nodes;
  for (const int index : nodes) {
    const Node& node = scene.nodes[size_t(index)];
    if (node.camera >= 0 && info.cameras[size_t(node.camera)].node < 0) {
      info.cameras[size_t(node.camera)].node = index;
    }
    if (node.light >= 0) ++info.lights[size_t(node.light)].nodes;
    if (node.mesh < 0) continue;
    mesh_nodes.push_back(index);
    const MeshPose pose(scene, index, rest, CameraPose());
    bool mirrored = false;
    for (const MeshPrimitive& primitive : scene.meshes[size_t(node.mesh)].primitives) {
      ++info.drawn_primitives;
      info.drawn_triangles += int64_t(primitive.triangles.size());
      mirrored = mirrored || pose.Mirrors(primitive);
    }
    info.mirrored_nodes += mirrored;
  }
  info.mesh_nodes = int64_t(mesh_nodes.size());
  info.bounds = WorldBounds(scene, mesh_nodes, rest);
  return info;
}

FrameInfo DescribeFrame(const FrameScene& frame) {
  FrameInfo info;
  info.primitives = int64_t(frame.primitives.size());
  info.triangles = int64_t(frame.triangles.size());
  info.dropped_triangles = frame.dropped_triangles;
  info.warnings = frame.warnings;
  info.primitives_by_degree.assign(kMaxMotionDegree + 1, 0);
  info.triangles_by_degree.assign(kMaxMotionDegree + 1, 0);
  for (const FramePrimitive& primitive : frame.primitives) {
    info.vertices += primitive.vertex_count;
    ++info.primitives_by_degree[size_t(primitive.degree)];
    info.triangles_by_degree[size_t(primitive.degree)] += primitive.triangle_count;
    if (primitive.degree > 0) ++info.moving_by_pieces[primitive.pieces];
    if (std::isfinite(primitive.motion_pixels)) {
      info.largest_motion_pixels = std::max(info.largest_motion_pixels, primitive.motion_pixels);
    }
  }
  return info;
}

std::string MotionSummary(const FrameInfo& info) {
  std::string text = absl::StrCat(info.primitives, info.primitives == 1 ? " primitive: " : " primitives: ");
  absl::StrAppend(&text, info.primitives_by_degree[0], " still");
  for (size_t degree = 1; degree < info.primitives_by_degree.size(); ++degree) {
    if (info.primitives_by_degree[degree] == 0) continue;
    absl::StrAppend(&text, ", ", info.primitives_by_degree[degree], " of degree ", degree);
  }
  for (const auto& [pieces, count] : info.moving_by_pieces) {
    if (pieces > 1) absl::StrAppend(&text, "; ", count, " in ", pieces, " pieces");
  }
  if (info.largest_motion_pixels > 0) {
    absl::StrAppend(&text, absl::StrFormat("; at most %.1f px", info.largest_motion_pixels));
  }
  return text;
}

std::string KindName(PunctualLight::Kind kind) {
  switch (kind) {
    case PunctualLight::Kind::kDirectional:
      return "directional";
    case PunctualLight::Kind::kPoint:
      return "point";
    case PunctualLight::Kind::kSpot:
      return "spot";
  }
  return "";
}

}  // namespace shutterline::engine
