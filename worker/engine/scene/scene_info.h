#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "common/math/spaces.h"
#include "worker/engine/scene/frame_scene.h"
#include "worker/engine/scene/scene.h"

namespace shutterline::engine {

/// What a scene contains, for people and for the `info` command.
struct SceneInfo {
  struct CameraInfo {
    std::string name;
    bool perspective = true;
    /// The first node of the default scene that places it, -1 where none does (it cannot be chosen then).
    int node = -1;
  };
  struct AnimationInfo {
    std::string name;
    int64_t channels = 0;
    int64_t keys = 0;
    double first_key_seconds = 0, last_key_seconds = 0;
    int64_t step = 0, linear = 0, cubic_spline = 0;                       ///< Channels by interpolation.
    int64_t translation = 0, rotation = 0, scale = 0, morph_weights = 0;  ///< Channels by what they animate.
  };
  struct SkinInfo {
    std::string name;
    int64_t joints = 0;
  };
  struct ImageInfo {
    std::string name;
    int width = 0, height = 0;
    int bits = 8;  ///< A channel.
  };
  struct LightInfo {
    std::string name;
    PunctualLight::Kind kind = PunctualLight::Kind::kPoint;
    int64_t nodes = 0;  ///< Of the default scene, that place it.
  };

  std::string name;
  int64_t nodes = 0;             ///< In the file.
  int64_t scene_nodes = 0;       ///< In the default scene.
  int64_t mesh_nodes = 0;        ///< Nodes of the default scene that draw a mesh.
  int64_t mirrored_nodes = 0;    ///< Of these, with a negative determinant at rest.
  int64_t meshes = 0;            ///< In the file.
  int64_t mesh_primitives = 0;   ///< In the file.
  int64_t vertices = 0;          ///< Stored.
  int64_t stored_triangles = 0;  ///< In the file; triangles that primitives share count once.
  int64_t drawn_triangles = 0;   ///< By the default scene, with all instances.
  int64_t drawn_primitives = 0;
  int64_t materials = 0;  ///< Without glTF's default material.
  int64_t textures = 0;
  int64_t texture_pixels = 0;  ///< Of all images.
  int64_t morph_targets = 0;   ///< Summed over meshes; those of one mesh's primitives count once.
  /// How many of these materials use what, by name: "unlit", "alpha mask", "normal texture"; those of 0 are
  /// left out.
  std::map<std::string, int64_t> materials_with;
  std::vector<ImageInfo> images;
  std::vector<LightInfo> lights;
  std::vector<CameraInfo> cameras;
  std::vector<AnimationInfo> animations;
  std::vector<SkinInfo> skins;
  /// World bounds of the default scene at rest (no animation), metres; empty where nothing is drawn.
  Box3d bounds;
  ImportReport import;
};

SceneInfo DescribeScene(const Scene& scene);

/// What a frame of a scene contains.
struct FrameInfo {
  int64_t primitives = 0, triangles = 0, vertices = 0;
  int64_t dropped_triangles = 0;
  /// By degree of motion, 0 (static) to 3.
  std::vector<int64_t> primitives_by_degree, triangles_by_degree;
  std::map<int, int64_t> moving_by_pieces;  ///< Primitives that move, by pieces of the shutter.
  /// Largest motion_pixels of the primitives that are in front of the near plane throughout.
  double largest_motion_pixels = 0;
  std::vector<std::string> warnings;
};

FrameInfo DescribeFrame(const FrameScene& frame);

/// The motion that was chosen, in a line: "12 primitives: 3 still, 7 of degree 1, 2 of degree 3; 2 in 4
/// pieces; at most 35.2 px".
std::string MotionSummary(const FrameInfo& info);

/// "directional", "point" or "spot".
std::string KindName(PunctualLight::Kind kind);

}  // namespace shutterline::engine
