#include "worker/engine/scene/pose.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/engine/scene_motion/scene_builder.h"
#include "worker/engine/scene/animation_select.h"
#include "worker/engine/scene/mesh_pose.h"
#include "worker/engine/scene/scene_bounds.h"

namespace shutterline::engine::pose_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

const double kRightAngle = std::acos(0.0);

PoseSampler Sampler(const SceneBuilder& b) {
  return PoseSampler(*b.scene, *SelectChannels(*b.scene, ""));
}

void ExpectNear(const V3d& actual, const V3d& expected, double tolerance) {
  EXPECT_NEAR(actual.x, expected.x, tolerance);
  EXPECT_NEAR(actual.y, expected.y, tolerance);
  EXPECT_NEAR(actual.z, expected.z, tolerance);
}

void AddSpin(SceneBuilder& b, int node, double angle) {
  b.AddChannel(node, AnimatedPath::kRotation, {0, 1},
               {0, 0, 0, 1, 0, 0, float(std::sin(angle / 2)), float(std::cos(angle / 2))});
}

TEST(Pose, ScaleThenRotationThenTranslation) {
  NodeTransform transform;
  transform.translation = {10, 20, 30};
  transform.rotation.setAxisAngle(V3d(0, 0, 1), kRightAngle);
  transform.scale = {2, 3, 4};
  // (1, 1, 1) -> (2, 3, 4) -> (-3, 2, 4) -> (7, 22, 34).
  ExpectNear(V3d(1, 1, 1) * LocalMatrix(transform), V3d(7, 22, 34), 1e-13);
}

TEST(Pose, NestedRotationsInClosedForm) {
  // An arm of length 2 turns about the origin, an arm of length 1 about its end, both about z.
  SceneBuilder b;
  const int shoulder = b.AddNode();
  const int elbow = b.AddNode(shoulder, V3d(2, 0, 0));
  AddSpin(b, shoulder, 1.0);
  AddSpin(b, elbow, 0.5);
  const PoseSampler sampler = Sampler(b);
  for (double t = 0; t <= 1; t += 0.125) {
    const V3d hand = V3d(1, 0, 0) * sampler.At(t).world_from_node[size_t(elbow)];
    const double a = t, c = 1.5 * t;
    ExpectNear(hand, V3d(2 * std::cos(a) + std::cos(c), 2 * std::sin(a) + std::sin(c), 0), 1e-7);
  }
}

TEST(Pose, ChildrenBeforeParentsInTheFile) {
  SceneBuilder b;
  b.AddNode(-1, V3d(1, 0, 0));
  b.AddNode(-1, V3d(0, 1, 0));
  // Node 0 becomes the child of node 1.
  b.scene->nodes[0].parent = 1;
  b.scene->nodes[1].children = {0};
  b.scene->roots = {1};
  ExpectNear(V3d(0) * Sampler(b).At(0).world_from_node[0], V3d(1, 1, 0), 0);
}

TEST(Pose, WhatMoves) {
  SceneBuilder b;
  const int still = b.AddNode(), parent = b.AddNode(), child = b.AddNode(parent);
  const int skinned = b.AddNode(-1, V3d(0), b.AddMesh(Triangle()));
  const int morphed = b.AddNode(-1, V3d(0), 0);
  b.scene->skins.push_back({"skin", {child}, {M44d()}});
  b.scene->nodes[size_t(skinned)].skin = 0;
  AddSpin(b, parent, 1);
  b.AddChannel(morphed, AnimatedPath::kWeights, {0, 1}, {0, 1});
  const PoseSampler sampler = Sampler(b);
  EXPECT_FALSE(sampler.Moves(still));
  EXPECT_TRUE(sampler.Moves(parent));
  EXPECT_TRUE(sampler.Moves(child));
  EXPECT_FALSE(sampler.Moves(skinned));
  EXPECT_TRUE(sampler.MeshMoves(skinned));
  EXPECT_FALSE(sampler.Moves(morphed));
  EXPECT_TRUE(sampler.MeshMoves(morphed));
}

TEST(Pose, KeyTimesInsideTheShutter) {
  SceneBuilder b;
  const int node = b.AddNode();
  b.AddChannel(node, AnimatedPath::kTranslation, {0, 1, 2, 3}, std::vector<float>(12, 0));
  b.AddChannel(node, AnimatedPath::kScale, {0.5f, 2, 4}, std::vector<float>(9, 1));
  const PoseSampler sampler = Sampler(b);
  EXPECT_THAT(sampler.KeyTimes(0, 3, 10), ElementsAre(0.5, 1, 2));
  EXPECT_THAT(sampler.KeyTimes(1, 2, 10), IsEmpty());
  EXPECT_THAT(sampler.KeyTimes(-1, 9, 2), SizeIs(2));
  EXPECT_EQ(sampler.KeyRange(), (std::pair<double, double>(0, 4)));
}

TEST(AnimationSelect, NamesBeforeIndicesBeforeWords) {
  Scene scene;
  scene.name = "clips.gltf";
  for (const char* name : {"walk", "0", "none", "run"}) {
    AnimationChannel channel;
    channel.node = 0;
    channel.times = {float(scene.animations.size())};
    scene.animations.push_back({name, {channel}});
  }
  const auto first_time = [&](absl::string_view name) {
    const auto channels = SelectChannels(scene, name);
    return channels.ok() && channels->size() == 1 ? (*channels)[0]->times[0] : -1;
  };
  EXPECT_EQ(first_time(""), 0);
  EXPECT_EQ(first_time("run"), 3);
  EXPECT_EQ(first_time("0"), 1);
  EXPECT_EQ(first_time("2"), 2);
  EXPECT_EQ(first_time("none"), 2);
  EXPECT_THAT(*SelectChannels(scene, "all"), SizeIs(4));
  for (const char* wrong : {"4", "-1", "+1", "1.0", "Walk", " 1", "99999999999999999999"}) {
    const absl::Status status = SelectChannels(scene, wrong).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << wrong;
    EXPECT_THAT(std::string(status.message()), HasSubstr("clips.gltf"));
    EXPECT_THAT(std::string(status.message()), HasSubstr("\"walk\""));
  }
  scene.animations.clear();
  EXPECT_THAT(*SelectChannels(scene, ""), IsEmpty());
  EXPECT_THAT(*SelectChannels(scene, "none"), IsEmpty());
  EXPECT_THAT(*SelectChannels(scene, "all"), IsEmpty());
}

TEST(MeshPose, SkinBlendsTwoJoints) {
  // Joint 0 stands still, joint 1 turns about (1, 0, 0); a vertex at (2, 0, 0) follows both equally.
  SceneBuilder b;
  MeshPrimitive primitive = Triangle();
  primitive.positions = {{2, 0, 0}, {0, 1, 0}, {0, 2, 0}};
  primitive.influences.resize(3);
  primitive.influences[0].joints = {0, 1};
  primitive.influences[0].weights = {0.5f, 0.5f};
  primitive.influences[1].joints = {1};
  primitive.influences[1].weights = {1};
  const int root = b.AddNode();
  const int joint0 = b.AddNode(root), joint1 = b.AddNode(root, V3d(1, 0, 0));
  // The mesh node's own transform must not matter.
  const int node = b.AddNode(root, V3d(100, 100, 100), b.AddMesh(primitive));
  M44d bind1;
  bind1.setTranslation(V3d(-1, 0, 0));
  b.scene->skins.push_back({"skin", {joint0, joint1}, {M44d(), bind1}});
  b.scene->nodes[size_t(node)].skin = 0;
  AddSpin(b, joint1, kRightAngle);
  const MeshPrimitive& stored = b.scene->meshes[0].primitives[0];
  const PoseSampler sampler = Sampler(b);

  const MeshPose rest(*b.scene, node, sampler.At(0), CameraPose());
  for (uint32_t v = 0; v < 2; ++v) ExpectNear(rest.Position(stored, v), V3d(stored.positions[v]), 1e-12);
  const MeshPose turned(*b.scene, node, sampler.At(1), CameraPose());
  // Joint 1 takes (2, 0, 0) to (1, 1, 0) and (0, 1, 0) to (0, -1, 0).
  ExpectNear(turned.Position(stored, 0), V3d(1.5, 0.5, 0), 1e-6);
  ExpectNear(turned.Position(stored, 1), V3d(0, -1, 0), 1e-6);
}

TEST(MeshPose, MorphTargetsAddUp) {
  SceneBuilder b;
  MeshPrimitive primitive = Triangle();
  primitive.normals.assign(3, V3f(0, 0, 1));
  primitive.targets.resize(3);
  primitive.targets[0].positions.assign(3, V3f(1, 0, 0));
  primitive.targets[1].normals.assign(3, V3f(0, 1, 0));
  primitive.targets[2].positions.assign(3, V3f(0, 0, 8));
  const int mesh = b.AddMesh(primitive);
  b.scene->meshes[0].weights = {0.5f, 1, 0};
  const int by_mesh = b.AddNode(-1, V3d(0), mesh), by_node = b.AddNode(-1, V3d(0), mesh),
            by_clip = b.AddNode(-1, V3d(0), mesh);
  b.scene->nodes[size_t(by_node)].weights = {0, 0, 0.25f};
  b.AddChannel(by_clip, AnimatedPath::kWeights, {0, 1}, {0, 0, 0, 2, 0, 1});
  const MeshPrimitive& stored = b.scene->meshes[0].primitives[0];
  const Pose pose = Sampler(b).At(0.5);
  const auto position = [&](int node) {
    return MeshPose(*b.scene, node, pose, CameraPose()).Position(stored, 0);
  };
  EXPECT_EQ(position(by_mesh), V3d(0.5, 0, 0));
  EXPECT_EQ(position(by_node), V3d(0, 0, 2));
  EXPECT_EQ(position(by_clip), V3d(1, 0, 4));
  ExpectNear(MeshPose(*b.scene, by_mesh, pose, CameraPose()).Normal(stored, 0),
             V3d(0, std::sqrt(0.5), std::sqrt(0.5)), 1e-15);
}

TEST(SceneBounds, CoverTheWholeAnimationAndOnlyWhatIsDrawn) {
  SceneBuilder b;
  MeshPrimitive primitive = Triangle();
  primitive.positions.push_back({1000, 1000, 1000});  // No triangle uses it.
  const int mesh = b.AddMesh(primitive);
  const int node = b.AddNode(-1, V3d(0), mesh);
  b.AddNode(-1, V3d(0, -3, 0), mesh);
  b.AddChannel(node, AnimatedPath::kTranslation, {2, 6}, {0, 0, 0, 0, 0, 7});
  const Box3d box = AnimationBounds(Sampler(b));
  EXPECT_EQ(box.min, V3d(0, -3, 0));
  EXPECT_EQ(box.max, V3d(1, 1, 7));
}

}  // namespace
}  // namespace shutterline::engine::pose_test
