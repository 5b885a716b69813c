#include "worker/engine/scene/frame_light.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "tests/engine/scene_motion/scene_builder.h"

namespace shutterline::engine::frame_light_test {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

struct LitScene : SceneBuilder {
  LitScene() {
    AddCamera();
    AddNode(-1, V3d(0), AddMesh(Triangle()));
  }
  /// A node with a light of its own.
  int AddLight(PunctualLight::Kind kind, int parent = -1, const V3d& translation = V3d(0)) {
    const int node = AddNode(parent, translation);
    scene->nodes[size_t(node)].light = int(scene->lights.size());
    scene->lights.emplace_back();
    scene->lights.back().kind = kind;
    return node;
  }
  NodeTransform& transform(int node) { return scene->nodes[size_t(node)].transform; }
  std::shared_ptr<const FrameScene> Build(const RenderSettings& settings = SquareSettings(), int frame = 0) {
    const auto built = BuildFrameScene(scene, frame, settings);
    EXPECT_TRUE(built.ok()) << built.status();
    return built.ok() ? *built : nullptr;
  }
};

void ExpectNear(const V3d& actual, const V3d& expected, double tolerance = 1e-12) {
  EXPECT_LT((actual - expected).length(), tolerance) << actual << " is not " << expected;
}

TEST(FrameLight, StandsAndShinesWhereItsNodeSays) {
  LitScene s;
  const int node = s.AddLight(PunctualLight::Kind::kSpot, -1, V3d(1, 2, 3));
  PunctualLight& in = s.scene->lights[0];
  in.color = {1, 0.5f, 0.25f};
  in.intensity = 8;
  in.range = 7;
  in.inner_cone = 0.25f;
  in.outer_cone = 0.5f;
  // Turned by a right angle about x, -z becomes y; scale and mirroring across it do not matter.
  s.transform(node).rotation.setAxisAngle(V3d(1, 0, 0), std::acos(0));
  for (const V3d& scale : {V3d(1), V3d(3), V3d(0.1, 5, 2), V3d(-1, 1, 1)}) {
    s.transform(node).scale = scale;
    const auto frame = s.Build();
    ASSERT_EQ(frame->lights.size(), 1u);
    const FrameLight& light = frame->lights[0];
    EXPECT_EQ(light.kind, PunctualLight::Kind::kSpot);
    ExpectNear(light.position, V3d(1, 2, 3 - 5));  // The camera is at (0, 0, 5) and looks along -z.
    ExpectNear(light.direction, V3d(0, 1, 0));
    EXPECT_EQ(light.intensity, V3f(8, 4, 2));
    EXPECT_EQ(light.range, 7);
    EXPECT_NEAR(light.cos_inner, std::cos(0.25), 1e-12);
    EXPECT_NEAR(light.cos_outer, std::cos(0.5), 1e-12);
  }
}

TEST(FrameLight, OnlyOfTheDefaultSceneAndInItsOrder) {
  LitScene s;
  const int away = s.AddLight(PunctualLight::Kind::kPoint);
  s.scene->roots.pop_back();
  s.AddLight(PunctualLight::Kind::kDirectional, -1, V3d(1, 0, 0));
  const int parent = s.AddNode(-1, V3d(2, 0, 0));
  const int child = s.AddNode(parent, V3d(0, 1, 0));
  s.scene->nodes[size_t(child)].light = s.scene->nodes[size_t(away)].light;  // One light, placed twice.
  const auto frame = s.Build();
  ASSERT_EQ(frame->lights.size(), 2u);
  EXPECT_EQ(frame->lights[0].kind, PunctualLight::Kind::kDirectional);
  EXPECT_EQ(frame->lights[1].kind, PunctualLight::Kind::kPoint);
  ExpectNear(frame->lights[1].position, V3d(2, 1, -5));
}

TEST(FrameLight, IsTakenAtMidShutterAndFromTheMovingCamera) {
  LitScene s;
  const int node = s.AddLight(PunctualLight::Kind::kPoint);
  s.AddChannel(node, AnimatedPath::kTranslation, {0, 1}, {0, 0, 0, 4, 0, 0});
  // Nothing else moves; the light does.
  ExpectNear(s.Build()->lights[0].position, V3d(2, 0, -5));
  s.AddChannel(0, AnimatedPath::kTranslation, {0, 1}, {0, 0, 5, 0, 2, 5});
  ExpectNear(s.Build()->lights[0].position, V3d(2, -1, -5));
  RenderSettings still = SquareSettings();
  still.shutter_close = 0;
  ExpectNear(s.Build(still)->lights[0].position, V3d(0, 0, -5));
}

TEST(FrameLight, WithoutPlaceOrDirectionIsLeftOutAndNamed) {
  LitScene s;
  const int sun = s.AddLight(PunctualLight::Kind::kDirectional);
  const int bulb = s.AddLight(PunctualLight::Kind::kPoint);
  for (const int node : {sun, bulb}) s.transform(node).scale = V3d(0);
  auto frame = s.Build();
  ASSERT_EQ(frame->lights.size(), 1u);  // A point light needs no direction.
  EXPECT_EQ(frame->lights[0].kind, PunctualLight::Kind::kPoint);
  ASSERT_EQ(frame->warnings.size(), 1u);
  EXPECT_THAT(frame->warnings[0], HasSubstr("node 2 \"node2\", light 0"));
  s.transform(bulb).translation.x = std::numeric_limits<double>::infinity();
  EXPECT_THAT(s.Build()->lights, IsEmpty());
}

TEST(FrameLight, IntensityStaysFinite) {
  LitScene s;
  s.AddLight(PunctualLight::Kind::kPoint);
  s.scene->lights[0].color = {1e30f, 1, 0};
  s.scene->lights[0].intensity = 1e30f;
  EXPECT_EQ(s.Build()->lights[0].intensity, V3f(std::numeric_limits<float>::max(), 1e30f, 0));
}

TEST(FrameView, WorldAxesTakeDirectionsToTheWorld) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-1, 1);
  EXPECT_EQ(LitScene().Build()->view.world_axes[1], V3d(0, 1, 0));
  for (int trial = 0; trial < 20; ++trial) {
    LitScene s;
    Quatd& turn = s.transform(0).rotation;
    turn = Quatd(uniform(random), uniform(random), uniform(random), uniform(random));
    turn.normalize();
    const auto frame = s.Build();
    for (const V3d& in_camera : {V3d(1, 0, 0), V3d(0, 0, -1), V3d(0.3, -0.4, 0.5)}) {
      const V3d in_world = in_camera * turn.toMatrix44();
      for (size_t i = 0; i < 3; ++i) {
        EXPECT_NEAR(frame->view.world_axes[i].dot(in_camera), in_world[int(i)], 1e-12) << "trial " << trial;
      }
    }
  }
}

TEST(FrameView, WorldAxesAreThoseOfMidShutter) {
  LitScene s;
  // A quarter turn about y over the shutter: half-way, the camera looks between -z and -x.
  const auto h = float(std::sqrt(0.5));
  s.AddChannel(0, AnimatedPath::kRotation, {0, 1}, {0, 0, 0, 1, 0, h, 0, h});
  const auto frame = s.Build();
  const V3d forward(0, 0, -1);
  EXPECT_NEAR(frame->view.world_axes[0].dot(forward), -std::sqrt(0.5), 1e-6);
  EXPECT_NEAR(frame->view.world_axes[2].dot(forward), -std::sqrt(0.5), 1e-6);
}

}  // namespace
}  // namespace shutterline::engine::frame_light_test
