#include "worker/engine/scene/scene_info.h"

#include <gtest/gtest.h>

#include "tests/engine/scene_motion/scene_builder.h"

namespace shutterline::engine::scene_info_test {
namespace {

TEST(SceneInfo, CountsWhatIsStoredAndWhatIsDrawn) {
  SceneBuilder b;
  b.AddCamera();
  MeshPrimitive primitive = Triangle();
  primitive.targets.resize(2);
  const int mesh = b.AddMesh(primitive);
  b.AddMesh(Triangle(), "not drawn");
  const int node = b.AddNode(-1, V3d(0), mesh);
  const int mirrored = b.AddNode(-1, V3d(5, 0, 0), mesh);
  b.scene->nodes[size_t(mirrored)].transform.scale = {-1, 1, 1};
  b.scene->skins.push_back({"bones", {0, 1}, {M44d(), M44d()}});
  b.AddChannel(node, AnimatedPath::kTranslation, {1, 2.5f}, {0, 0, 0, 1, 0, 0}, Interpolation::kStep);
  b.AddChannel(node, AnimatedPath::kWeights, {0.5f, 2}, {0, 0, 1, 1});
  const SceneInfo info = DescribeScene(*b.scene);
  EXPECT_EQ(info.nodes, 3);
  EXPECT_EQ(info.mesh_nodes, 2);
  EXPECT_EQ(info.mirrored_nodes, 1);
  EXPECT_EQ(info.meshes, 2);
  EXPECT_EQ(info.vertices, 6);
  EXPECT_EQ(info.stored_triangles, 2);
  EXPECT_EQ(info.drawn_triangles, 2);
  EXPECT_EQ(info.morph_targets, 2);
  EXPECT_EQ(info.materials, 0);
  EXPECT_EQ(info.bounds.min, V3d(0, 0, 0));
  EXPECT_EQ(info.bounds.max, V3d(5, 1, 0));
  ASSERT_EQ(info.cameras.size(), 1u);
  EXPECT_EQ(info.cameras[0].node, 0);
  ASSERT_EQ(info.animations.size(), 1u);
  EXPECT_EQ(info.animations[0].channels, 2);
  EXPECT_EQ(info.animations[0].keys, 4);
  EXPECT_EQ(info.animations[0].first_key_seconds, 0.5);
  EXPECT_EQ(info.animations[0].last_key_seconds, 2.5);
  EXPECT_EQ(info.animations[0].step, 1);
  EXPECT_EQ(info.animations[0].morph_weights, 1);
  ASSERT_EQ(info.skins.size(), 1u);
  EXPECT_EQ(info.skins[0].joints, 2);
}

TEST(SceneInfo, TellsLightsAndWhatMaterialsUse) {
  SceneBuilder b;
  b.AddNode(-1, V3d(0), b.AddMesh(Triangle()));
  b.scene->images.resize(2);
  b.scene->images[0].rgba = {1, 2, 3, 4};
  b.scene->images[1].rgba16 = {1, 2, 3, 4};
  b.scene->textures.resize(1);
  Material& shiny = b.scene->materials[0];
  shiny.normal_texture.texture = 0;
  shiny.emissive_texture.texture = 0;
  shiny.emissive_texture.transform.rotation = 1;
  shiny.emissive_factor = {0, 0, 2};
  Material flat;
  flat.unlit = true;
  flat.alpha_mode = AlphaMode::kMask;
  flat.normal_texture.texture = 0;  // Not looked at.
  b.scene->materials.push_back(flat);
  b.scene->materials.emplace_back();  // glTF's default material.
  b.scene->lights.resize(2);
  b.scene->lights[0].kind = PunctualLight::Kind::kDirectional;
  b.scene->lights[1].kind = PunctualLight::Kind::kSpot;
  for (int i = 0; i < 2; ++i) b.scene->nodes[size_t(b.AddNode())].light = 1;
  const SceneInfo info = DescribeScene(*b.scene);
  EXPECT_EQ(info.materials_with, (std::map<std::string, int64_t>{{"alpha mask", 1},
                                                                 {"emission", 1},
                                                                 {"emissive texture", 1},
                                                                 {"normal texture", 1},
                                                                 {"texture transform", 1},
                                                                 {"unlit", 1}}));
  ASSERT_EQ(info.lights.size(), 2u);
  EXPECT_EQ(info.lights[0].nodes, 0);
  EXPECT_EQ(info.lights[1].nodes, 2);
  EXPECT_EQ(KindName(info.lights[1].kind), "spot");
  EXPECT_EQ(info.images[0].bits, 8);
  EXPECT_EQ(info.images[1].bits, 16);
}

TEST(FrameInfo, CountsByDegree) {
  SceneBuilder b;
  b.AddCamera();
  const int mesh = b.AddMesh(Triangle());
  const int node = b.AddNode(-1, V3d(0), mesh);
  b.AddNode(-1, V3d(1, 0, 0), mesh);
  b.AddNode(-1, V3d(2, 0, 0), mesh);
  b.AddChannel(node, AnimatedPath::kTranslation, {0, 1}, {0, 0, 0, 1, 0, 0});
  const auto frame = BuildFrameScene(b.scene, 0, SquareSettings());
  ASSERT_TRUE(frame.ok());
  const FrameInfo info = DescribeFrame(**frame);
  EXPECT_EQ(info.primitives_by_degree, (std::vector<int64_t>{2, 1, 0, 0}));
  EXPECT_EQ(info.triangles_by_degree, (std::vector<int64_t>{2, 1, 0, 0}));
  EXPECT_EQ(info.moving_by_pieces, (std::map<int, int64_t>{{1, 1}}));
  EXPECT_EQ(info.vertices, 9);
  EXPECT_NEAR(info.largest_motion_pixels, 20, 1e-9);
}

}  // namespace
}  // namespace shutterline::engine::scene_info_test
