#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "tests/scenes/glb_writer.h"
#include "tests/scenes/scene_generators.h"
#include "worker/engine/scene/frame_scene.h"
#include "worker/engine/scene/gltf_import.h"
#include "worker/engine/scene/memory_asset_source.h"

// The scenes that have textures, beside the same without.
namespace shutterline::scenes {
namespace {

SceneOptions Textured() {
  SceneOptions options;
  options.textured = true;
  return options;
}

/// All of a scene's triangles as one list of positions and of indices into it, in the file's order. However
/// they are cut into primitives, they are the same triangles.
struct Triangles {
  std::vector<V3f> positions;
  std::vector<std::array<size_t, 3>> corners;

  explicit Triangles(const GlbScene& scene) {
    for (const Mesh& mesh : scene.meshes) {
      for (const Primitive& primitive : mesh.primitives) {
        const size_t first = positions.size();
        positions.insert(positions.end(), primitive.positions.begin(), primitive.positions.end());
        for (const auto& [a, b, c] : primitive.triangles)
          corners.push_back({first + a, first + b, first + c});
      }
    }
  }
};

/// Every picture is used, and what uses pictures has coordinates on them.
void ExpectPicturesAndTheirUsers(const GlbScene& scene) {
  std::set<int> used;
  size_t lit = 0;
  for (const Mesh& mesh : scene.meshes) {
    for (const Primitive& primitive : mesh.primitives) {
      const Material& material = scene.materials[size_t(primitive.material)];
      if (material.color_texture.image < 0) {
        EXPECT_TRUE(material.unlit) << material.name;
        continue;
      }
      ++lit;
      used.insert({material.color_texture.image, material.metallic_roughness_texture.image,
                   material.normal_texture.image});
      EXPECT_FALSE(material.unlit);
      EXPECT_EQ(primitive.normals.size(), primitive.positions.size());
      ASSERT_EQ(primitive.texcoords.size(), primitive.positions.size());
      for (const V2f& place : primitive.texcoords) {
        // Pictures repeat, but so far out floats would still tell texels apart.
        ASSERT_LE(std::max(std::abs(place.x), std::abs(place.y)), 64) << material.name;
      }
    }
  }
  EXPECT_GT(lit, 0u);
  EXPECT_EQ(used.count(-1), 0u);
  EXPECT_EQ(used.size(), scene.images.size());
}

class TexturedScene : public testing::TestWithParam<std::string> {};

TEST_P(TexturedScene, HasThePlainTrianglesTheirMotionAndPictures) {
  const GlbScene plain = GenerateScene(GetParam()).value();
  const GlbScene textured = GenerateScene(GetParam(), Textured()).value();
  EXPECT_EQ(plain.DrawnTriangles(), textured.DrawnTriangles());
  const Triangles before(plain), after(textured);
  EXPECT_TRUE(before.positions == after.positions);
  EXPECT_TRUE(before.corners == after.corners);
  ASSERT_EQ(plain.channels.size(), textured.channels.size());
  for (size_t i = 0; i < plain.channels.size(); ++i) {
    EXPECT_EQ(plain.channels[i].times, textured.channels[i].times);
    EXPECT_EQ(plain.channels[i].values, textured.channels[i].values);
  }
  ExpectPicturesAndTheirUsers(textured);
}

/// What benchmarks measure, and what options mean that say nothing of textures.
TEST_P(TexturedScene, PlainHasNoTrace) {
  const GlbScene plain = GenerateScene(GetParam()).value();
  EXPECT_TRUE(plain.images.empty());
  for (const Mesh& mesh : plain.meshes) {
    for (const Primitive& primitive : mesh.primitives) EXPECT_TRUE(primitive.texcoords.empty());
  }
  const std::string bytes = EncodeGlb(plain);
  EXPECT_EQ(bytes.find("TEXCOORD"), std::string::npos);
  EXPECT_EQ(bytes.find("exture"), std::string::npos);
}

TEST_P(TexturedScene, IsTheSameAgainAndImportsWithoutAWord) {
  const std::string name = GetParam() + ".glb", bytes = GenerateGlb(GetParam(), Textured()).value();
  EXPECT_TRUE(bytes == GenerateGlb(GetParam(), Textured()).value());
  const auto scene = engine::ImportGltf(engine::MemoryAssetSource(name, {{name, bytes}}));
  ASSERT_TRUE(scene.ok()) << scene.status();
  EXPECT_THAT((*scene)->report.warnings, testing::IsEmpty());
  ASSERT_FALSE((*scene)->images.empty());
  for (const engine::TextureImage& image : (*scene)->images) {
    EXPECT_EQ(image.width, image.height) << image.name;
    EXPECT_TRUE(image.width == 512 || image.width == 1024) << image.name;
  }
  const auto posed = engine::BuildFrameScene(*scene, 3, {});
  ASSERT_TRUE(posed.ok()) << posed.status();
  EXPECT_EQ(int64_t((*posed)->triangles.size()), GenerateScene(GetParam())->DrawnTriangles());
}

std::vector<std::string> WithTextures() {
  std::vector<std::string> names;
  for (const SceneInfo& info : AllScenes()) {
    if (info.has_textures) names.push_back(info.name);
  }
  return names;
}

INSTANTIATE_TEST_SUITE_P(All, TexturedScene, testing::ValuesIn(WithTextures()),
                         [](const auto& scene) { return scene.param; });

TEST(TexturedScenes, AreThePapersFourAndNoOther) {
  EXPECT_THAT(WithTextures(), testing::UnorderedElementsAre("chess", "armadillo", "clothball", "hall"));
  for (const SceneInfo& info : AllScenes()) {
    if (info.has_textures) continue;
    EXPECT_TRUE(GenerateGlb(info.name).value() == GenerateGlb(info.name, Textured()).value()) << info.name;
  }
}

}  // namespace
}  // namespace shutterline::scenes
