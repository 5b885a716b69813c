// Imports end when their time is over, wherever they are.
#include <absl/strings/match.h>
#include <absl/strings/str_cat.h>
#include <gtest/gtest.h>

#include <random>

#include "common/base/work_limit.h"
#include "tests/engine/scene_import/import_helpers.h"
#include "tests/support/ticking_clock.h"

namespace shutterline::engine::import_limit_test {
namespace {

/// Something of everything that a file may have much of.
GltfBuilder Everything() {
  GltfBuilder file;
  const int positions = file.Floats("VEC3", {0, 0, 0, 1, 0, 0, 0, 1, 0});
  nlohmann::json targets = nlohmann::json::array();
  for (int i = 0; i < 5; ++i) targets.push_back({{"POSITION", positions}});
  const int mesh = file.Mesh({{"attributes", {{"POSITION", positions}}}, {"targets", targets}});
  nlohmann::json channels = nlohmann::json::array();
  for (int i = 0; i < 5; ++i) {
    const int node = file.Draw(mesh);
    channels.push_back({{"sampler", 0}, {"target", {{"node", node}, {"path", "translation"}}}});
    file.Add("skins", {{"joints", {node}}});
  }
  const int times = file.Floats("SCALAR", {0, 1}), places = file.Floats("VEC3", {0, 0, 0, 1, 1, 1});
  file.Add("animations", {{"samplers", {{{"input", times}, {"output", places}}}}, {"channels", channels}});
  return file;
}

TEST(ImportLimit, EndsAnImportAtAnyLookAtTheClock) {
  const std::string bytes = Everything().Glb();
  const auto import = [&](int64_t seconds, int64_t& looks) {
    const test::TickingClock clock;
    const auto scene =
        WithinWorkLimit(clock, absl::Seconds(seconds), "outside", [&] { return ImportBytes(bytes); });
    looks = clock.looks();
    return scene.status();
  };
  int64_t all = 0, looks = 0;
  ASSERT_TRUE(import(1'000'000, all).ok());
  // Documents, meshes and their targets, nodes, skins, channels and what accessors hold are all looked after.
  EXPECT_GT(all, 40);
  for (int64_t seconds = 0; seconds + 2 < all; ++seconds) {
    const absl::Status status = import(seconds, looks);
    ASSERT_EQ(status, absl::DeadlineExceededError(
                          absl::StrCat("load scene test.glb: it took longer than the ",
                                       absl::FormatDuration(absl::Seconds(seconds)), " that are allowed")));
    EXPECT_EQ(looks, seconds + 2) << "it ends at the first look that is too late";
  }
  EXPECT_TRUE(import(all, looks).ok());
}

TEST(ImportLimit, PosedJointsAndWeightsAreBoundedByTheNodesThatPoseThem) {
  ImportLimits limits;
  limits.base_posed = 30;
  limits.drawn_per_file_byte = 0;
  EXPECT_TRUE(ImportBytes(Everything().Glb(), limits).ok());  // Five nodes of five weights.
  limits.base_posed = 24;
  const absl::Status status = MustFail(Everything(), limits);
  EXPECT_TRUE(absl::IsResourceExhausted(status));
  EXPECT_TRUE(absl::StrContains(status.message(), "node 4: 5 joints and morph weights posed more than 20"))
      << status;
  // Joints count as well, each time that a node has them.
  GltfBuilder skinned = Everything();
  skinned.json["nodes"][0]["skin"] = 0;
  limits.base_posed = 25;
  EXPECT_TRUE(absl::IsResourceExhausted(MustFail(skinned, limits)));
}

TEST(ImportLimit, MemoryHasABoundWhateverTheFilesSize) {
  ImportLimits limits;
  limits.base_memory = 100;
  limits.max_memory = 200;
  EXPECT_TRUE(absl::IsResourceExhausted(MustFail(Everything(), limits)));
  limits.max_memory = 1 << 20;
  EXPECT_TRUE(ImportBytes(Everything().Glb(), limits).ok());
}

}  // namespace
}  // namespace shutterline::engine::import_limit_test
