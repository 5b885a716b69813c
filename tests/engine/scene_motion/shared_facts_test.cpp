#include "worker/engine/scene/shared_facts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <numeric>
#include <random>
#include <thread>

#include "tests/engine/scene_motion/scene_builder.h"
#include "worker/engine/scene/frame_scene.h"
#include "worker/engine/scene/scene_bounds.h"

namespace shutterline::engine::shared_facts_test {
namespace {

template <typename T>
bool EqualBits(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

/// All that a picture is made of, but for pointers.
void ExpectEqualFrames(const FrameScene& a, const FrameScene& b) {
  EXPECT_EQ(a.view.scale_x, b.view.scale_x);
  EXPECT_EQ(a.view.znear, b.view.znear);
  EXPECT_TRUE(EqualBits(a.control_points, b.control_points));
  EXPECT_TRUE(EqualBits(a.normals, b.normals));
  EXPECT_TRUE(EqualBits(a.triangles, b.triangles));
  EXPECT_EQ(a.warnings, b.warnings);
  EXPECT_EQ(a.dropped_triangles, b.dropped_triangles);
  ASSERT_EQ(a.primitives.size(), b.primitives.size());
  for (size_t i = 0; i < a.primitives.size(); ++i) {
    EXPECT_EQ(a.primitives[i].degree, b.primitives[i].degree);
    EXPECT_EQ(a.primitives[i].pieces, b.primitives[i].pieces);
    EXPECT_EQ(a.primitives[i].linear_pieces, b.primitives[i].linear_pieces);
    EXPECT_EQ(a.primitives[i].motion_pixels, b.primitives[i].motion_pixels);
  }
}

/// A bumpy strip of `count` vertices, with normals and a morph target.
MeshPrimitive Strip(uint32_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> unit(-0.2f, 0.2f);
  MeshPrimitive strip;
  strip.targets.resize(1);
  for (uint32_t v = 0; v < count; ++v) {
    strip.positions.emplace_back(3 * float(v) / float(count) + unit(random), float(v % 2), unit(random));
    strip.normals.emplace_back(unit(random), unit(random), 1.0f);
    strip.targets[0].positions.emplace_back(unit(random), unit(random), unit(random));
    if (v >= 2) strip.triangles.push_back({v - 2, v - 1, v});
  }
  return strip;
}

/// What turns, what morphs, what stands still; no camera, so that frames stand where the animation's bounds
/// say.
std::shared_ptr<Scene> AnimatedScene() {
  SceneBuilder b;
  const int turning = b.AddNode(-1, V3d(0), b.AddMesh(Strip(1500, 1)));
  const int morphing = b.AddNode(-1, V3d(0, 2, -1), b.AddMesh(Strip(300, 2)));
  b.AddNode(-1, V3d(0, -2, 0), 0);
  b.AddChannel(turning, AnimatedPath::kRotation, {0, 2, 4},
               {0, 0, 0, 1, 0, 0, 0.70710678f, 0.70710678f, 0, 0, 1, 0});
  b.AddChannel(morphing, AnimatedPath::kWeights, {0, 1, 4}, {0, 1, 0.25f});
  return b.scene;
}

TEST(SharedFacts, FramesInAnyOrderAreThoseMadeAlone) {
  const std::shared_ptr<const Scene> scene = AnimatedScene();
  std::vector<int> order(4);
  std::iota(order.begin(), order.end(), 0);
  std::mt19937 random(3);
  for (int round = 0; round < 3; ++round) {
    std::shuffle(order.begin(), order.end(), random);
    for (const int frame : order) {
      SCOPED_TRACE(testing::Message() << "frame " << frame << ", round " << round);
      const auto shared = BuildFrameScene(scene, frame, SquareSettings());
      const auto alone = BuildFrameScene(AnimatedScene(), frame, SquareSettings());
      ASSERT_TRUE(shared.ok() && alone.ok());
      ExpectEqualFrames(**shared, **alone);
    }
  }
}

TEST(SharedFacts, FramesMadeAtOnceAreThoseMadeAlone) {
  const std::shared_ptr<const Scene> scene = AnimatedScene();
  std::vector<std::shared_ptr<const FrameScene>> made(4);
  std::vector<std::thread> threads;
  for (size_t i = 0; i < made.size(); ++i) {
    threads.emplace_back([&, i] { made[i] = BuildFrameScene(scene, int(i), SquareSettings()).value(); });
  }
  for (std::thread& thread : threads) thread.join();
  for (size_t i = 0; i < made.size(); ++i) {
    ExpectEqualFrames(*made[i], **BuildFrameScene(AnimatedScene(), int(i), SquareSettings()));
  }
}

TEST(SharedFacts, BoundsAreThoseOfTheChannelsAskedFor) {
  const std::shared_ptr<Scene> scene = AnimatedScene();
  const std::vector<AnimationChannel>& all = scene->animations[0].channels;
  const std::vector<std::vector<const AnimationChannel*>> selections = {
      {}, {&all[0]}, {&all[1]}, {&all[0], &all[1]}, {&all[1], &all[0]}, {&all[0], &all[0]}};
  for (int round = 0; round < 2; ++round) {
    for (const auto& channels : selections) {
      const PoseSampler sampler(*scene, channels);
      EXPECT_EQ(scene->facts.BoundsOf(sampler), AnimationBounds(sampler));
    }
  }
}

TEST(SharedFacts, ACopyOfASceneFindsItsOwn) {
  const std::shared_ptr<Scene> scene = AnimatedScene();
  const auto first = BuildFrameScene(scene, 0, SquareSettings());
  const auto copy = std::make_shared<Scene>(*scene);
  copy->meshes[0].primitives[0] = Strip(700, 9);
  copy->meshes[0].primitives[0].triangles.resize(10);
  const auto of_copy = BuildFrameScene(copy, 0, SquareSettings());
  ASSERT_TRUE(first.ok() && of_copy.ok());
  EXPECT_EQ((*of_copy)->triangles.size(), 10u + 10u + 298u);
  EXPECT_EQ(scene->facts.VertexSetsOf(scene->meshes, 0)->at(0).used.size(), 1500u);
  EXPECT_EQ(copy->facts.VertexSetsOf(copy->meshes, 0)->at(0).used.size(), 700u);
}

}  // namespace
}  // namespace shutterline::engine::shared_facts_test
