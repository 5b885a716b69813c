#pragma once

#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tests/scenes/glb_scene.h"

/// Scenes that anyone can generate again, for tests, benchmarks and the demonstration. All have a camera;
/// plane, fan, debris, trees and static have unlit flat colours, so that a picture's error is visibility's
/// alone; armadillo and clothball have unlit vertex colours unless they are textured; chess, hall and demo
/// are lit. Speeds refer to frames of 1024 × 768 pixels at 24 frames a second with the shutter open from 0 to
/// 0.5 frames, and hold in every frame from 0 to 23. Equal names and options give equal bytes.
namespace shutterline::scenes {

/// What is not set is the scene's own default.
struct SceneOptions {
  uint64_t seed = 1;
  std::optional<int> triangles;         ///< About how many.
  std::optional<int> tessellation;      ///< Cells a side.
  std::optional<double> motion_pixels;  ///< Over the default shutter; what moves so is the scene's to say.
  /// Chess, armadillo, clothball and hall of wood, marble, stone, cloth: lit, with textures. The triangles
  /// and their motion are the same. Without, which is what benchmarks measure, they have plain colours.
  bool textured = false;
};

struct SceneInfo {
  std::string name;
  std::string summary;  ///< A line for people.
  /// The options that the scene takes beside the seed: their least and largest values, where least <=
  /// largest.
  int min_triangles = 1, max_triangles = 0;
  int min_tessellation = 1, max_tessellation = 0;
  double max_motion = -1;  ///< From 0.
  bool has_textures = false;
};

const std::vector<SceneInfo>& AllScenes();

/// NOT_FOUND for an unknown name (the message lists those known), INVALID_ARGUMENT for an option that the
/// scene does not take or that is out of its range.
absl::StatusOr<GlbScene> GenerateScene(absl::string_view name, const SceneOptions& options = {});

/// GenerateScene as a GLB file's bytes.
absl::StatusOr<std::string> GenerateGlb(absl::string_view name, const SceneOptions& options = {});

}  // namespace shutterline::scenes
