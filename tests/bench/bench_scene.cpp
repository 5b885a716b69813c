#include "tests/bench/bench_scene.h"

#include <absl/strings/str_cat.h>

#include <algorithm>

#include "common/base/status_macros.h"
#include "tests/bench/stopwatch.h"
#include "tests/support/engine_frame.h"
#include "tests/support/shared_scenes.h"
#include "worker/engine/scene/directory_asset_source.h"
#include "worker/engine/scene/gltf_import.h"
#include "worker/engine/scene/memory_asset_source.h"

namespace shutterline::bench {
namespace {

BenchScene Generated(const std::string& name, bool moves = true) {
  return {
      .name = name, .generator = name, .options = {}, .path = "", .moves = moves, .frame = 0, .settings = {}};
}

BenchScene Shared(const std::string& folder, const std::string& name, int frame, bool moves = true) {
  return {.name = name,
          .generator = "",
          .options = {},
          .path = absl::StrCat(folder, "/", name, "/", name, ".glb"),
          .moves = moves,
          .frame = frame,
          .settings = {}};
}

std::vector<BenchScene> GeneratedScenes() {
  std::vector<BenchScene> scenes;
  for (const int cells : {16, 64}) {
    scenes.push_back(Generated("plane"));
    scenes.back().name = absl::StrCat("plane", cells);
    scenes.back().options.tessellation = cells;
  }
  for (const char* name : {"chess", "trees", "armadillo", "fan", "clothball", "hall", "debris"}) {
    scenes.push_back(Generated(name));
  }
  scenes.push_back(Generated("static", /*moves=*/false));
  return scenes;
}

/// Looked for once: it says loudly where there are none.
const std::vector<BenchScene>& SharedScenes() {
  static const std::vector<BenchScene> shared = [] {
    std::vector<BenchScene> scenes;
    const auto folder = FindSharedScenes();
    if (!folder) return scenes;
    scenes.push_back(Shared(*folder, "CesiumMilkTruck", 2));
    scenes.push_back(Shared(*folder, "BoxAnimated", 36));
    scenes.push_back(Shared(*folder, "VintageDeskFan", 10));
    scenes.push_back(Shared(*folder, "RodTwist", 0));
    scenes.back().settings.fps = 1;  // Its only motion takes a second.
    scenes.back().settings.shutter_close = 1;
    scenes.push_back(Shared(*folder, "OpenChessSet", 0, /*moves=*/false));
    return scenes;
  }();
  return shared;
}

const BenchScene* Find(const std::vector<BenchScene>& scenes, const std::string& name) {
  const auto found =
      std::find_if(scenes.begin(), scenes.end(), [&](const BenchScene& scene) { return scene.name == name; });
  return found == scenes.end() ? nullptr : &*found;
}

}  // namespace

std::vector<BenchScene> AllBenchScenes() {
  std::vector<BenchScene> scenes = GeneratedScenes();
  scenes.insert(scenes.end(), SharedScenes().begin(), SharedScenes().end());
  return scenes;
}

std::vector<BenchScene> QuickBenchScenes() {
  return {Generated("chess"), Generated("fan"), Generated("trees"), Generated("static", /*moves=*/false)};
}

absl::StatusOr<std::vector<BenchScene>> BenchScenesNamed(const std::vector<std::string>& names) {
  const std::vector<BenchScene> generated = GeneratedScenes();
  std::vector<BenchScene> result;
  for (const std::string& name : names) {
    const BenchScene* scene = Find(generated, name);
    if (scene == nullptr) scene = Find(SharedScenes(), name);
    if (scene == nullptr) {
      std::string known;
      for (const BenchScene& s : AllBenchScenes()) absl::StrAppend(&known, known.empty() ? "" : ", ", s.name);
      return absl::NotFoundError(absl::StrCat("no scene is named '", name, "'; there are ", known));
    }
    result.push_back(*scene);
  }
  return result;
}

absl::StatusOr<LoadedScene> Load(const BenchScene& scene) {
  LoadedScene result;
  if (!scene.generator.empty()) {
    SL_ASSIGN_OR_RETURN(std::string glb, scenes::GenerateGlb(scene.generator, scene.options));
    const Stopwatch watch;
    SL_ASSIGN_OR_RETURN(result.scene, engine::ImportGltf(engine::MemoryAssetSource(
                                          "scene.glb", {{"scene.glb", std::move(glb)}})));
    result.import_seconds = watch.Wall();
    return result;
  }
  SL_ASSIGN_OR_RETURN(const auto source, engine::DirectoryAssetSource::Open(scene.path));
  const Stopwatch watch;
  SL_ASSIGN_OR_RETURN(const auto imported, engine::ImportGltf(*source));
  result.import_seconds = watch.Wall();
  result.scene = engine::WithFlatColors(*imported);
  return result;
}

}  // namespace shutterline::bench
