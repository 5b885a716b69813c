// Frames that take too long to be made ready are given up, wherever their making is.
#include <gtest/gtest.h>

#include <random>

#include "common/base/work_limit.h"
#include "tests/engine/scene_motion/scene_builder.h"
#include "tests/support/ticking_clock.h"

namespace shutterline::engine::frame_limit_test {
namespace {

/// Meshes that jump about under a camera, or without one.
std::shared_ptr<const Scene> Jumping(bool camera) {
  std::mt19937 random(1);
  const auto number = [&] { return float(random() % 1000) / 1000; };
  SceneBuilder builder;
  if (camera) builder.AddCamera();
  MeshPrimitive primitive;
  for (uint32_t i = 0; i < 3 * 600; ++i) primitive.positions.emplace_back(number(), number(), number());
  for (uint32_t i = 0; i < 600; ++i) primitive.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  primitive.normals.assign(primitive.positions.size(), V3f(0, 0, 1));
  primitive.targets.push_back({primitive.positions, {}});
  const int mesh = builder.AddMesh(primitive);
  builder.scene->meshes[0].weights = {0};
  for (int i = 0; i < 6; ++i) {
    const int node = builder.AddNode(-1, V3d(0), mesh);
    builder.AddChannel(node, AnimatedPath::kWeights, {0, 0.3f, 0.7f}, {number(), number(), number()},
                       Interpolation::kStep);
  }
  return builder.scene;
}

TEST(FrameLimit, EndsTheMakingOfAFrameWhereverItIs) {
  for (const bool camera : {true, false}) {
    const auto scene = Jumping(camera);
    const auto build = [&](int64_t seconds, int64_t& looks) {
      const test::TickingClock clock;
      auto frame = WithinWorkLimit(clock, absl::Seconds(seconds), "make the frame",
                                   [&] { return BuildFrameScene(scene, 0, SquareSettings()); });
      looks = clock.looks();
      return frame;
    };
    int64_t all = 0, looks = 0;
    const auto whole = build(1'000'000'000, all);
    ASSERT_TRUE(whole.ok()) << whole.status();
    EXPECT_GT(all, 5'000) << "seven steps of pieces with hundreds of times each";
    for (const int64_t share : {1'000, 100, 10, 4, 2}) {
      const auto stopped = build(all / share, looks);
      EXPECT_TRUE(absl::IsDeadlineExceeded(stopped.status())) << stopped.status();
      // Threads look once more each, and no more work than that is done.
      EXPECT_LT(looks, all / share + 1'000);
    }
    // What was given up left nothing behind.
    const auto again = build(2 * all, looks);
    ASSERT_TRUE(again.ok()) << again.status();
    EXPECT_EQ((*again)->control_points.size(), (*whole)->control_points.size());
    EXPECT_TRUE((*again)->control_points == (*whole)->control_points);
  }
}

}  // namespace
}  // namespace shutterline::engine::frame_limit_test
