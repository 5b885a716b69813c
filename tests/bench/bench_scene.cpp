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

}  // namespace

std::vector<BenchScene> AllBenchScenes() {
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
  const auto folder = FindSharedScenes();
  if (!folder) return scenes;
  scenes.push_back(Shared(*folder, "CesiumMilkTruck", 2));
  scenes.push_back(Shared(*folder, "BoxAnimated", 36));
  scenes.push_back(Shared(*folder, "VintageDeskFan", 10));
  BenchScene rod = Shared(*folder, "RodTwist", 0);
  rod.settings.fps = 1;
  rod.settings.shutter_close = 1;
  scenes.push_back(rod);
  scenes.push_back(Shared(*folder, "OpenChessSet", 0, /*moves=*/false));
  return scenes;
}

std::vector<BenchScene> QuickBenchScenes() {
  return {Generated("chess"), Generated("fan"), Generated("trees"), Generated("static", /*moves=*/false)};
}

absl::StatusOr<std::vector<BenchScene>> BenchScenesNamed(const std::vector<std::string>& names) {
  const std::vector<BenchScene> all = AllBenchScenes();
  std::vector<BenchScene> result;
  for (const std::string& name : names) {
    const auto found =
        std::find_if(all.begin(), all.end(), [&](const BenchScene& scene) { return scene.name == name; });
    if (found == all.end()) {
      std::string known;
      for (const BenchScene& scene : all) absl::StrAppend(&known, known.empty() ? "" : ", ", scene.name);
      return absl::NotFoundError(absl::StrCat("no scene is named '", name, "'; there are ", known));
    }
    result.push_back(*found);
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
