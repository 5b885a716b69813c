#pragma once

#include <absl/status/statusor.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/job/render_settings.h"
#include "tests/scenes/scene_generators.h"
#include "worker/engine/scene/scene.h"

namespace shutterline::bench {

/// A scene of the report and the frame of it that is rendered.
struct BenchScene {
  std::string name;              ///< Unique in the report.
  std::string generator;         ///< A generated scene's name; empty for a file.
  scenes::SceneOptions options;  ///< Without textures, so that numbers of all dates compare.
  std::string path;              ///< Of a file; rendered with unlit flat colours, one a material.
  bool moves = true;             ///< Counts among the moving scenes.
  int frame = 0;
  /// Size, fps, shutter, camera and animation; the method's fields are the contenders' to set.
  RenderSettings settings;
};

/// The nine generated scenes (`plane` in two tessellations, so ten), then, where the folder of shared
/// scenes is present, real ones.
std::vector<BenchScene> AllBenchScenes();
/// Four of them for a first look.
std::vector<BenchScene> QuickBenchScenes();
/// Those of AllBenchScenes() with these names; NOT_FOUND names those there are.
absl::StatusOr<std::vector<BenchScene>> BenchScenesNamed(const std::vector<std::string>& names);

struct LoadedScene {
  std::shared_ptr<const engine::Scene> scene;
  double import_seconds = 0;  ///< From the file's bytes in memory to the scene; textures decoded.
};

/// Generates or reads, then imports.
absl::StatusOr<LoadedScene> Load(const BenchScene& scene);

}  // namespace shutterline::bench
