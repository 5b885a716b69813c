#pragma once

#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "common/job/render_settings.h"
#include "worker/engine/scene/frame_scene.h"

/// Small scenes for the tests of motion and shading, built as structs.
namespace shutterline::engine {

/// A counter-clockwise triangle in the plane z = 0, seen from +z.
inline MeshPrimitive Triangle() {
  MeshPrimitive primitive;
  primitive.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  primitive.triangles = {{0, 1, 2}};
  return primitive;
}

/// A scene of one material, with helpers that return indices. Nodes without a parent are roots.
struct SceneBuilder {
  std::shared_ptr<Scene> scene = std::make_shared<Scene>();

  SceneBuilder() {
    scene->name = "test";
    scene->materials.emplace_back();
  }
  int AddMesh(MeshPrimitive primitive, const std::string& name = "mesh") {
    Mesh mesh;
    mesh.name = name;
    mesh.primitives.push_back(std::move(primitive));
    scene->meshes.push_back(std::move(mesh));
    return int(scene->meshes.size()) - 1;
  }
  int AddNode(int parent = -1, const V3d& translation = V3d(0), int mesh = -1) {
    const int index = int(scene->nodes.size());
    Node node;
    node.name = "node" + std::to_string(index);
    node.parent = parent;
    node.mesh = mesh;
    node.transform.translation = translation;
    scene->nodes.push_back(node);
    (parent < 0 ? scene->roots : scene->nodes[size_t(parent)].children).push_back(index);
    return index;
  }
  /// A camera node that looks along -z, with a vertical field of view of 2 atan(1/2) (focal length = frame
  /// height) and the near plane at 0.1.
  int AddCamera(int parent = -1, const V3d& translation = V3d(0, 0, 5)) {
    Camera camera;
    camera.name = "camera";
    camera.yfov = 2 * std::atan(0.5);
    scene->cameras.push_back(camera);
    const int node = AddNode(parent, translation);
    scene->nodes[size_t(node)].camera = int(scene->cameras.size()) - 1;
    return node;
  }
  AnimationChannel& AddChannel(int node, AnimatedPath path, std::vector<float> times,
                               std::vector<float> values,
                               Interpolation interpolation = Interpolation::kLinear) {
    if (scene->animations.empty()) scene->animations.push_back({"clip", {}});
    AnimationChannel channel;
    channel.node = node;
    channel.path = path;
    channel.interpolation = interpolation;
    const size_t per_key = values.size() / times.size();
    channel.width = int(interpolation == Interpolation::kCubicSpline ? per_key / 3 : per_key);
    channel.times = std::move(times);
    channel.values = std::move(values);
    scene->animations[0].channels.push_back(std::move(channel));
    return scene->animations[0].channels.back();
  }
};

/// 100 x 100 pixels, one frame a second, the shutter open for all of it: t is the time in seconds.
inline RenderSettings SquareSettings() {
  RenderSettings settings;
  settings.width = settings.height = 100;
  settings.fps = 1;
  settings.shutter_open = 0;
  settings.shutter_close = 1;
  return settings;
}

inline V2d Raster(const RasterPoint& p) {
  return {p.x / p.w, p.y / p.w};
}

}  // namespace shutterline::engine
