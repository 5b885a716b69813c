#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/engine/scene_import/import_helpers.h"

// Nodes, skins, cameras and animations.
namespace shutterline::engine::node_test {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;

TEST(GltfNodes, ReadsTransformsAndMatricesForRowVectors) {
  GltfBuilder file;
  const int node = file.DrawTriangle();
  file.json["nodes"][size_t(node)].update(
      {{"translation", {1, 2, 3}}, {"rotation", {0, 0, 2, 0}}, {"scale", {-1, 2, 4}}});
  // glTF's memory holds a column after the other; the translation is the last.
  file.Add("nodes", {{"matrix", {1, 2, 3, 0, 5, 6, 7, 0, 9, 10, 11, 0, 13, 14, 15, 1}}});
  const auto scene = MustImport(file);
  const NodeTransform& trs = scene->nodes[0].transform;
  EXPECT_FALSE(trs.has_matrix);
  EXPECT_EQ(trs.translation, V3d(1, 2, 3));
  EXPECT_EQ(trs.scale, V3d(-1, 2, 4));
  EXPECT_EQ(trs.rotation.r, 0);  // Made a unit quaternion.
  EXPECT_EQ(trs.rotation.v, V3d(0, 0, 1));
  const NodeTransform& matrix = scene->nodes[1].transform;
  ASSERT_TRUE(matrix.has_matrix);
  EXPECT_EQ(V3d(0, 0, 0) * matrix.matrix, V3d(13, 14, 15));
  EXPECT_EQ(V3d(1, 0, 0) * matrix.matrix, V3d(14, 16, 18));
  EXPECT_EQ(scene->roots, std::vector<int>{0});
}

TEST(GltfNodes, AZeroRotationTurnsNothingAndIsSaid) {
  GltfBuilder file;
  file.json["nodes"][size_t(file.DrawTriangle())]["rotation"] = {0, 0, 0, 0};
  const auto scene = MustImport(file);
  EXPECT_EQ(scene->nodes[0].transform.rotation.r, 1);
  EXPECT_THAT(scene->report.warnings, ElementsAre(HasSubstr("node 0: a rotation of length 0")));
}

TEST(GltfNodes, RefusesCyclesTwoParentsAndChildrenInTheScene) {
  GltfBuilder file;
  file.DrawTriangle();
  file.json["nodes"] = {{{"mesh", 0}, {"children", {1}}}, {{"children", {2}}}, {{"children", {1}}}};
  EXPECT_THAT(MustFail(file).message(), HasSubstr("node 1: it has two parents, nodes 0 and 2"));
  file.json["nodes"] = {{{"mesh", 0}}, {{"children", {2}}}, {{"children", {1}}}};
  EXPECT_THAT(MustFail(file).message(), HasSubstr("node 1: its ancestors form a cycle"));
  file.json["nodes"] = {{{"mesh", 0}}, {{"children", {0}}}};
  EXPECT_THAT(MustFail(file).message(), HasSubstr("scene 0: node 0 is not a root, its parent is node 1"));
  file.json["nodes"] = {{{"mesh", 0}}, {{"mesh", 0}}};
  file.json["scenes"][0]["nodes"] = {0, 1, 0};
  EXPECT_THAT(MustFail(file).message(), HasSubstr("scene 0: it lists node 0 twice"));
}

TEST(GltfNodes, RefusesTreesDeeperThanTheLimit) {
  const auto chain = [](int length) {
    GltfBuilder file;
    file.DrawTriangle();
    for (int i = 1; i < length; ++i) {
      file.json["nodes"][size_t(i - 1)]["children"] = {i};
      file.Add("nodes", json::object());
    }
    return file;
  };
  EXPECT_TRUE(ImportBytes(chain(512).Glb()).ok());
  EXPECT_EQ(MustFail(chain(513)).code(), absl::StatusCode::kResourceExhausted);
}

TEST(GltfNodes, TheDefaultSceneIsTheNamedOneElseTheFirst) {
  GltfBuilder file;
  file.DrawTriangle();
  file.Draw(0);
  file.json["scenes"] = {{{"nodes", {1}}}, {{"nodes", {0}}}, json::object()};
  EXPECT_EQ(MustImport(file)->roots, std::vector<int>{1});
  file.json["scene"] = 1;
  EXPECT_EQ(MustImport(file)->roots, std::vector<int>{0});
  file.json["scene"] = 2;
  EXPECT_THAT(MustFail(file).message(), HasSubstr("nothing to draw"));
  file.json.erase("scene");
  file.json.erase("scenes");
  EXPECT_THAT(MustFail(file).message(), HasSubstr("nothing to draw: the file has no scene"));
}

/// A triangle with influences on the joints given, of which the skin has `joints`.
GltfBuilder Skinned(int joints, std::vector<uint8_t> vertex_joints, std::vector<float> vertex_weights) {
  GltfBuilder file;
  std::vector<uint8_t> all_joints;
  std::vector<float> all_weights;
  for (int v = 0; v < 3; ++v) {
    all_joints.insert(all_joints.end(), vertex_joints.begin(), vertex_joints.end());
    all_weights.insert(all_weights.end(), vertex_weights.begin(), vertex_weights.end());
  }
  const int node = file.Draw(file.Mesh({{"attributes",
                                         {{"POSITION", file.Floats("VEC3", {0, 0, 0, 1, 0, 0, 0, 1, 0})},
                                          {"JOINTS_0", file.Accessor("VEC4", 5121, all_joints)},
                                          {"WEIGHTS_0", file.Floats("VEC4", all_weights)}}}}));
  json skin = {{"joints", json::array()}};
  for (int j = 0; j < joints; ++j) skin["joints"].push_back(file.Add("nodes", json::object()));
  file.json["nodes"][size_t(node)]["skin"] = file.Add("skins", skin);
  return file;
}

TEST(GltfSkin, NormalisesWeightsAndReadsInverseBindMatrices) {
  GltfBuilder file = Skinned(2, {1, 0, 7, 7}, {3, 1, 0, 0});
  std::vector<float> matrices(32, 0.0f);
  for (const size_t i : {0, 5, 10, 15, 16, 21, 26, 31}) matrices[i] = 1;
  matrices[16 + 12] = 4;  // The second one translates by x = 4.
  file.json["skins"][0]["inverseBindMatrices"] = file.Floats("MAT4", matrices);
  const auto scene = MustImport(file);
  const VertexInfluences& influences = scene->meshes[0].primitives[0].influences[1];
  EXPECT_EQ(influences.weights[0], 0.75f);
  EXPECT_EQ(influences.weights[1], 0.25f);
  EXPECT_EQ(influences.joints[0], 1);
  EXPECT_EQ(influences.joints[2], 0);  // A joint without weight is not held against the skin.
  EXPECT_EQ(V3d(1, 1, 1) * scene->skins[0].inverse_bind_matrices[1], V3d(5, 1, 1));
  EXPECT_EQ(scene->skins[0].joints, (std::vector<int>{1, 2}));
}

TEST(GltfSkin, RefusesJointsThatTheSkinDoesNotHave) {
  EXPECT_THAT(MustFail(Skinned(2, {2, 0, 0, 0}, {1, 0, 0, 0})).message(),
              HasSubstr("node 0: mesh 0 uses joint 2, but skin 0 has 2"));
  GltfBuilder file = Skinned(1, {0, 0, 0, 0}, {1, 0, 0, 0});
  file.json["skins"][0]["joints"] = json::array();
  EXPECT_THAT(MustFail(file).message(), HasSubstr("skin 0: it has no joints"));
  file = Skinned(1, {0, 0, 0, 0}, {1, 0, 0, 0});
  file.json["meshes"][0]["primitives"][0]["attributes"].erase("WEIGHTS_0");
  EXPECT_THAT(MustFail(file).message(), HasSubstr("JOINTS_0 and WEIGHTS_0 need each other"));
}

TEST(GltfSkin, WeightsWithoutASumFollowTheFirstJointAndBadOnesDropTheTriangle) {
  const auto scene = MustImport(Skinned(2, {1, 0, 0, 0}, {0, 0, 0, 0}));
  EXPECT_EQ(scene->meshes[0].primitives[0].influences[0].joints[0], 1);
  EXPECT_EQ(scene->meshes[0].primitives[0].influences[0].weights[0], 1);
  EXPECT_EQ(scene->report.warnings.size(), 1u);
  EXPECT_THAT(MustFail(Skinned(2, {1, 0, 0, 0}, {std::nanf(""), 0, 0, 0})).message(),
              HasSubstr("1 triangles dropped"));
}

TEST(GltfCamera, ReadsBothKindsAndRefusesThoseWithoutAPicture) {
  GltfBuilder file;
  file.DrawTriangle();
  file.Add("cameras", {{"type", "perspective"}, {"perspective", {{"yfov", 0.5}, {"znear", 0.01}}}});
  file.Add("cameras", {{"type", "orthographic"},
                       {"name", "side"},
                       {"orthographic", {{"xmag", 2}, {"ymag", 3}, {"znear", 0}, {"zfar", 9}}}});
  const auto scene = MustImport(file);
  EXPECT_TRUE(scene->cameras[0].perspective);
  EXPECT_EQ(scene->cameras[0].yfov, 0.5);
  EXPECT_EQ(scene->cameras[0].zfar, 0);
  EXPECT_FALSE(scene->cameras[1].perspective);
  EXPECT_EQ(scene->cameras[1].ymag, 3);
  file.json["cameras"][1]["orthographic"]["xmag"] = 0;
  EXPECT_THAT(MustFail(file).message(), HasSubstr("camera 1 (side): xmag 0"));
  file.json["cameras"][1] = {{"type", "perspective"}};
  EXPECT_THAT(MustFail(file).message(), HasSubstr("erspective camera description not found"));
}

/// An animated triangle; `output` are the sampler's values.
GltfBuilder Animated(const char* path, const char* type, const char* interpolation, std::vector<float> times,
                     const std::vector<float>& output) {
  GltfBuilder file;
  file.DrawTriangle();
  file.Add("animations", {{"samplers",
                           {{{"input", file.Floats("SCALAR", times)},
                             {"output", file.Floats(type, output)},
                             {"interpolation", interpolation}}}},
                          {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", path}}}}}}});
  return file;
}

TEST(GltfAnimation, ReadsAllInterpolations) {
  auto scene = MustImport(Animated("translation", "VEC3", "STEP", {0, 2}, {1, 2, 3, 4, 5, 6}));
  const AnimationChannel* channel = &scene->animations[0].channels[0];
  EXPECT_EQ(channel->interpolation, Interpolation::kStep);
  EXPECT_THAT(channel->times, ElementsAre(0, 2));
  EXPECT_THAT(channel->values, ElementsAre(1, 2, 3, 4, 5, 6));
  scene = MustImport(Animated("scale", "VEC3", "CUBICSPLINE", {1}, {0, 0, 0, 1, 2, 3, 9, 9, 9}));
  channel = &scene->animations[0].channels[0];
  EXPECT_EQ(channel->path, AnimatedPath::kScale);
  EXPECT_EQ(channel->interpolation, Interpolation::kCubicSpline);
  EXPECT_EQ(channel->values.size(), 9u);
  scene = MustImport(Animated("rotation", "VEC4", "LINEAR", {0, 1}, {0, 0, 0, 1, 0, 0, 0, 0}));
  channel = &scene->animations[0].channels[0];
  EXPECT_EQ(channel->width, 4);
  EXPECT_THAT(channel->values, ElementsAre(0, 0, 0, 1, 0, 0, 0, 1));
  EXPECT_THAT(scene->report.warnings, ElementsAre(HasSubstr("key 1: a rotation of length 0")));
}

TEST(GltfAnimation, WeightsHaveTheWidthOfTheMorphTargets) {
  GltfBuilder file = Animated("weights", "SCALAR", "LINEAR", {0, 1}, {0, 1, 2, 3});
  EXPECT_TRUE(MustImport(file)->animations[0].channels.empty());  // No targets: left out with a warning.
  file.json["meshes"][0]["primitives"][0]["targets"] = {{{"POSITION", 0}}, {{"POSITION", 0}}};
  const auto scene = MustImport(file);
  EXPECT_EQ(scene->animations[0].channels[0].width, 2);
  EXPECT_THAT(scene->animations[0].channels[0].values, ElementsAre(0, 1, 2, 3));
}

TEST(GltfAnimation, RefusesKeysOutOfOrderAndOutputsOfAnotherLength) {
  const std::vector<float> two = {1, 2, 3, 4, 5, 6};
  EXPECT_THAT(MustFail(Animated("translation", "VEC3", "STEP", {1, 1}, two)).message(),
              HasSubstr("animation 0 channel 0: accessor 1 (key times): key 1 at 1 s is not after 1 s"));
  EXPECT_THAT(MustFail(Animated("translation", "VEC3", "STEP", {1, std::nanf("")}, two)).message(),
              HasSubstr("not finite"));
  EXPECT_THAT(MustFail(Animated("translation", "VEC3", "CUBICSPLINE", {0, 1}, two)).message(),
              HasSubstr("count 2 is not the 6 that 2 keys call for"));
  EXPECT_THAT(MustFail(Animated("rotation", "VEC3", "STEP", {0, 1}, two)).message(), HasSubstr("components"));
  EXPECT_THAT(MustFail(Animated("translation", "VEC3", "QUADRATIC", {0, 1}, two)).message(),
              HasSubstr("animation 0: samplers[0].interpolation: \"QUADRATIC\" is none of"));
}

TEST(GltfAnimation, LeavesOutWhatItCannotAnimateAndSaysSo) {
  GltfBuilder file = Animated("pointer", "VEC3", "STEP", {0, 1}, {1, 2, 3, 4, 5, 6});
  auto scene = MustImport(file);
  EXPECT_TRUE(scene->animations[0].channels.empty());
  EXPECT_THAT(scene->report.warnings, ElementsAre(HasSubstr("path \"pointer\" is unknown")));
  json& channels = file.json["animations"][0]["channels"];
  channels[0]["target"].erase("node");
  channels.push_back({{"sampler", 0}, {"target", {{"node", 0}, {"path", "translation"}}}});
  scene = MustImport(file);
  ASSERT_EQ(scene->animations[0].channels.size(), 1u);
  EXPECT_EQ(scene->animations[0].channels[0].path, AnimatedPath::kTranslation);
  EXPECT_THAT(scene->report.warnings, ElementsAre(HasSubstr("1 channels without a node")));
}

}  // namespace
}  // namespace shutterline::engine::node_test
