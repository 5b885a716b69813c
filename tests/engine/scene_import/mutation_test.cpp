#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <random>

#include "tests/engine/scene_import/import_helpers.h"
#include "tests/support/gltf_mutator.h"
#include "tests/support/gltf_seeds.h"
#include "tests/support/scene_invariants.h"

// Mutants of valid files either import to a scene that keeps the promises of scene.h, or fail with a
// message. SHUTTERLINE_FUZZ_SEED starts elsewhere; tests/fuzz/gltf_fuzz runs longer.
namespace shutterline::engine::mutation_test {
namespace {

TEST(GltfMutation, SeedsImportWhole) {
  for (const GltfBuilder& seed : GltfSeeds()) {
    const auto scene = MustImport(seed);
    EXPECT_EQ(BrokenSceneInvariant(*scene), "");
    EXPECT_EQ(scene->report.dropped_triangles, 0);
  }
}

TEST(GltfMutation, MutantsFailOrKeepTheScenesPromises) {
  const char* variable = std::getenv("SHUTTERLINE_FUZZ_SEED");
  const uint64_t first = variable != nullptr ? std::strtoull(variable, nullptr, 10) : 20110801;
  const std::vector<GltfBuilder> seeds = GltfSeeds();
  ImportLimits limits;
  limits.base_memory = uint64_t{16} << 20;
  limits.max_texture_pixels = 1 << 16;
  int imported = 0, failed = 0;
  for (uint64_t i = 0; i < 4000; ++i) {
    SCOPED_TRACE("seed " + std::to_string(first + i));
    std::mt19937_64 random(first + i);
    const std::string file = MutateGltf(seeds[i % seeds.size()], &random);
    const auto scene = ImportBytes(file, limits);
    if (scene.ok()) {
      ++imported;
      ASSERT_EQ(BrokenSceneInvariant(**scene), "");
    } else {
      ++failed;
      ASSERT_EQ(scene.status().message().substr(0, 21), "load scene test.glb: ");
      ASSERT_NE(scene.status().code(), absl::StatusCode::kInternal) << scene.status();
    }
  }
  // Were nearly all of one kind, the mutations would test little.
  EXPECT_GT(imported, 200);
  EXPECT_GT(failed, 1000);
}

}  // namespace
}  // namespace shutterline::engine::mutation_test
