#include <gtest/gtest.h>

#include <cmath>

#include "tests/scenes/scene_generators.h"
#include "worker/engine/scene/frame_scene.h"
#include "worker/engine/scene/gltf_import.h"
#include "worker/engine/scene/memory_asset_source.h"

namespace shutterline {
namespace {

class Imported : public testing::TestWithParam<std::string> {
 protected:
  static absl::StatusOr<std::shared_ptr<const engine::Scene>> Import(
      const scenes::SceneOptions& options = {}) {
    const std::string name = GetParam() + ".glb";
    return engine::ImportGltf(
        engine::MemoryAssetSource(name, {{name, scenes::GenerateGlb(GetParam(), options).value()}}));
  }
};

/// The scenes that take --motion.
class Moving : public Imported {};

/// The importer draws what the generator promised, without a word of complaint, in all frames of a job of
/// ten.
TEST_P(Imported, HasThePromisedTriangles) {
  const auto scene = Import();
  ASSERT_TRUE(scene.ok()) << scene.status();
  EXPECT_TRUE((*scene)->report.warnings.empty()) << (*scene)->report.warnings.front();
  const int64_t promised = scenes::GenerateScene(GetParam())->DrawnTriangles();
  for (const int frame : {0, 10}) {
    const auto posed = engine::BuildFrameScene(*scene, frame, {});
    ASSERT_TRUE(posed.ok()) << posed.status();
    EXPECT_EQ(int64_t((*posed)->triangles.size()), promised);
    EXPECT_EQ((*posed)->dropped_triangles, 0);
  }
}

/// The motion that the engine measures over the shutter is the one that was asked for.
TEST_P(Moving, MovesAsPromised) {
  const double wanted = 40;
  double tolerance = 0.01;
  scenes::SceneOptions options;
  options.motion_pixels = wanted;
  if (GetParam() == "debris") tolerance = 0.3;   // Speeds refer to centres, corners may be nearer.
  if (GetParam() == "fan") tolerance = 0.05;     // The arc is longer than its chord.
  if (GetParam() == "static") tolerance = 0.08;  // It leans towards the camera.
  if (GetParam() == "trees") tolerance = 0.05;   // For what would stand at the very front.
  const auto scene = Import(options);
  ASSERT_TRUE(scene.ok()) << scene.status();
  for (const int frame : {0, 7}) {
    const auto posed = engine::BuildFrameScene(*scene, frame, {});
    ASSERT_TRUE(posed.ok()) << posed.status();
    double most = 0;
    for (const auto& primitive : (*posed)->primitives) most = std::max(most, primitive.motion_pixels);
    EXPECT_NEAR(most, wanted, wanted * tolerance) << "frame " << frame;
  }
}

INSTANTIATE_TEST_SUITE_P(All, Imported,
                         testing::Values("plane", "fan", "debris", "trees", "static", "chess", "armadillo",
                                         "clothball", "hall", "demo"),
                         [](const auto& scene) { return scene.param; });

INSTANTIATE_TEST_SUITE_P(All, Moving, testing::Values("plane", "fan", "debris", "trees", "static"),
                         [](const auto& scene) { return scene.param; });

}  // namespace
}  // namespace shutterline
