#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "tests/scenes/glb_writer.h"
#include "tests/scenes/png_picture.h"
#include "worker/engine/scene/gltf_import.h"
#include "worker/engine/scene/memory_asset_source.h"

// Materials, textures and lights of generated scenes, as the engine reads them.
namespace shutterline::scenes {
namespace {

/// A textured triangle that a node draws.
GlbScene OneTriangle(Material material) {
  GlbScene scene;
  scene.name = "one";
  Primitive primitive;
  primitive.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  primitive.normals.assign(3, V3f(0, 0, 1));
  primitive.texcoords = {{0, 1}, {1, 1}, {0, 0}};
  primitive.triangles = {{0, 1, 2}};
  primitive.material = scene.Add(std::move(material));
  Node node;
  node.mesh = scene.Add(Mesh{"mesh", {primitive}});
  scene.Add(node);
  return scene;
}

std::shared_ptr<const engine::Scene> ReadBack(const GlbScene& scene) {
  const auto read = engine::ImportGltf(engine::MemoryAssetSource("a.glb", {{"a.glb", EncodeGlb(scene)}}));
  EXPECT_TRUE(read.ok()) << read.status();
  if (!read.ok()) return std::make_shared<const engine::Scene>();
  EXPECT_THAT((*read)->report.warnings, testing::IsEmpty());
  return *read;
}

TEST(GlbMaterial, FactorsAreReadBack) {
  Material material;
  material.unlit = false;
  material.color = {0.25f, 0.5f, 1};
  material.alpha = 0.75f;
  material.alpha_mode = AlphaMode::kMask;
  material.alpha_cutoff = 0.125f;
  material.metallic = 0.5f;
  material.roughness = 0.25f;
  material.emission = {1, 4, 2};
  material.ior = 1.75f;
  material.specular = 0.5f;
  material.specular_color = {1, 0.5f, 0.25f};
  const auto scene = ReadBack(OneTriangle(material));
  const engine::Material& read = scene->materials[0];
  EXPECT_FALSE(read.unlit);
  EXPECT_EQ(read.base_color_factor, V4f(0.25f, 0.5f, 1, 0.75f));
  EXPECT_EQ(read.alpha_mode, engine::AlphaMode::kMask);
  EXPECT_EQ(read.alpha_cutoff, 0.125f);
  EXPECT_EQ(read.metallic_factor, 0.5f);
  EXPECT_EQ(read.roughness_factor, 0.25f);
  EXPECT_EQ(read.emissive_factor, V3f(1, 4, 2));
  EXPECT_EQ(read.ior, 1.75f);
  EXPECT_EQ(read.specular_factor, 0.5f);
  EXPECT_EQ(read.specular_color_factor, V3f(1, 0.5f, 0.25f));
}

TEST(GlbMaterial, TexturesAreReadBack) {
  Material material;
  material.unlit = false;
  material.color_texture = {0, {0.5f, 0}, {2, 4}, 0.25f};
  material.metallic_roughness_texture.image = 1;
  material.normal_texture.image = 1;
  material.normal_scale = 0.5f;
  material.occlusion_texture.image = 1;
  material.occlusion_strength = 0.25f;
  material.emission_texture.image = 0;
  GlbScene written = OneTriangle(material);
  written.Add(Image{"wood", EncodePng({1, 2, 4, 8, {1, 2, 3, 4, 5, 6, 7, 8}})});
  written.Add(Image{"deep", EncodePng({1, 1, 3, 16, {1000, 2000, 3000}})});
  const auto scene = ReadBack(written);
  ASSERT_EQ(scene->images.size(), 2u);
  EXPECT_EQ(scene->images[0].name, "wood");
  EXPECT_THAT(scene->images[0].rgba, testing::ElementsAre(1, 2, 3, 4, 5, 6, 7, 8));
  EXPECT_THAT(scene->images[1].rgba16, testing::ElementsAre(1000, 2000, 3000, 65535));
  const engine::Material& read = scene->materials[0];
  EXPECT_EQ(read.base_color_texture.transform.offset, V2d(0.5, 0));
  EXPECT_EQ(read.base_color_texture.transform.scale, V2d(2, 4));
  EXPECT_EQ(read.base_color_texture.transform.rotation, 0.25);
  EXPECT_TRUE(read.emissive_texture.transform.IsIdentity());
  EXPECT_EQ(read.normal_texture.texture, read.metallic_roughness_texture.texture);
  EXPECT_EQ(read.normal_texture.texture, read.occlusion_texture.texture);
  EXPECT_EQ(read.normal_scale, 0.5f);
  EXPECT_EQ(read.occlusion_strength, 0.25f);
  const engine::MeshPrimitive& primitive = scene->meshes[0].primitives[0];
  EXPECT_EQ(primitive.texcoords[0][1], V2f(1, 1));
  EXPECT_EQ(primitive.tangents, std::vector<V4f>(3, V4f(1, 0, 0, 1)));

  written.meshes[0].primitives[0].tangents.assign(3, V4f(0, 1, 0, -1));
  EXPECT_EQ(ReadBack(written)->meshes[0].primitives[0].tangents, std::vector<V4f>(3, V4f(0, 1, 0, -1)));
}

TEST(GlbMaterial, LightsAreReadBack) {
  GlbScene written = OneTriangle(Material());
  written.Add(Light{Light::Kind::kDirectional, {1, 0.5f, 0.25f}, 3});
  Node node;
  node.light = written.Add(Light{Light::Kind::kSpot, {1, 1, 1}, 5, 9, 0.25f, 0.5f});
  written.Add(node);
  const auto scene = ReadBack(written);
  ASSERT_EQ(scene->lights.size(), 2u);
  EXPECT_EQ(scene->lights[0].kind, engine::PunctualLight::Kind::kDirectional);
  EXPECT_EQ(scene->lights[0].color, V3f(1, 0.5f, 0.25f));
  EXPECT_EQ(scene->lights[0].intensity, 3);
  EXPECT_EQ(scene->lights[1].kind, engine::PunctualLight::Kind::kSpot);
  EXPECT_EQ(scene->lights[1].range, 9);
  EXPECT_EQ(scene->lights[1].inner_cone, 0.25f);
  EXPECT_EQ(scene->lights[1].outer_cone, 0.5f);
  EXPECT_EQ(scene->nodes[1].light, 1);
  EXPECT_EQ(scene->nodes[0].light, -1);
}

}  // namespace
}  // namespace shutterline::scenes
