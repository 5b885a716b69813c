#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "tests/support/shared_scenes.h"
#include "worker/engine/scene/directory_asset_source.h"
#include "worker/engine/scene/gltf_import.h"
#include "worker/engine/scene/tangent_space.h"

// Real files that others made, held against the counts that their collection lists.
namespace shutterline::engine::shared_scenes_test {
namespace {

struct Expected {
  const char* file;
  int64_t stored, drawn;
  size_t animations, skins, joints, targets, cameras;
};

constexpr Expected kScenes[] = {
    {"OpenChessSet/OpenChessSet.glb", 329132, 1430784, 0, 0, 0, 0, 0},
    {"MetalRoughSpheresNoTextures/MetalRoughSpheresNoTextures.glb", 12209, 1040409, 0, 0, 0, 0, 0},
    {"ToyCar/ToyCar.glb", 108936, 108936, 0, 0, 0, 0, 8},
    {"CesiumMilkTruck/CesiumMilkTruck.glb", 2856, 3624, 1, 0, 0, 0, 0},
    {"BoxAnimated/BoxAnimated.glb", 254, 254, 1, 0, 0, 0, 0},
    {"VintageDeskFan/VintageDeskFan.glb", 21080, 21080, 4, 3, 4, 0, 0},
    {"Fox/Fox.glb", 576, 576, 3, 1, 24, 0, 0},
    {"CesiumMan/CesiumMan.glb", 4672, 4672, 1, 1, 19, 0, 0},
    {"RecursiveSkeletons/RecursiveSkeletons.glb", 76, 6384, 1, 84, 10, 0, 0},
    {"AnimatedMorphCube/AnimatedMorphCube.glb", 12, 12, 1, 0, 0, 2, 0},
    {"MorphStressTest/MorphStressTest.glb", 2412, 2412, 3, 0, 0, 8, 0},
    {"RodTwist/RodTwist.glb", 79864, 79864, 1, 0, 0, 1, 0},
    {"InterpolationTest/InterpolationTest.gltf", 110, 110, 9, 0, 0, 0, 0},
    {"Cameras/Cameras.gltf", 2, 2, 0, 0, 0, 0, 2},
    {"VertexColorTest/VertexColorTest.glb", 36, 36, 0, 0, 0, 0, 0},
    {"NegativeScaleTest/NegativeScaleTest.glb", 1324, 7724, 0, 0, 0, 0, 0},
    {"SimpleSparseAccessor/SimpleSparseAccessor.gltf", 12, 12, 0, 0, 0, 0, 0},
    {"AlphaBlendModeTest/AlphaBlendModeTest.glb", 61, 61, 0, 0, 0, 0, 0},
};

int64_t DrawnTriangles(const Scene& scene, int n) {
  const Node& node = scene.nodes[size_t(n)];
  int64_t count = 0;
  if (node.mesh >= 0) {
    for (const MeshPrimitive& primitive : scene.meshes[size_t(node.mesh)].primitives) {
      count += int64_t(primitive.triangles.size());
    }
  }
  for (const int child : node.children) count += DrawnTriangles(scene, child);
  return count;
}

TEST(SharedScenes, ImportWithTheCountsThatAreListed) {
  const auto folder = FindSharedScenes();
  if (!folder.has_value()) GTEST_SKIP();
  for (const Expected& expected : kScenes) {
    SCOPED_TRACE(expected.file);
    auto source = DirectoryAssetSource::Open(*folder + "/" + expected.file);
    ASSERT_TRUE(source.ok()) << source.status();
    const auto imported = ImportGltf(**source);
    ASSERT_TRUE(imported.ok()) << imported.status();
    const Scene& scene = **imported;
    int64_t drawn = 0;
    for (const int root : scene.roots) drawn += DrawnTriangles(scene, root);
    EXPECT_EQ(scene.report.stored_triangles, expected.stored);
    EXPECT_EQ(drawn, expected.drawn);
    EXPECT_EQ(scene.animations.size(), expected.animations);
    EXPECT_EQ(scene.skins.size(), expected.skins);
    for (const Skin& skin : scene.skins) EXPECT_EQ(skin.joints.size(), expected.joints);
    size_t targets = 0;
    for (const Mesh& mesh : scene.meshes) targets = std::max(targets, mesh.weights.size());
    EXPECT_EQ(targets, expected.targets);
    EXPECT_EQ(scene.cameras.size(), expected.cameras);
    EXPECT_EQ(scene.report.dropped_triangles, 0);
  }
}

TEST(SharedScenes, SparseAccessorMovesTheThreeVerticesItNames) {
  const auto folder = FindSharedScenes();
  if (!folder.has_value()) GTEST_SKIP();
  auto source = DirectoryAssetSource::Open(*folder + "/SimpleSparseAccessor/SimpleSparseAccessor.gltf");
  ASSERT_TRUE(source.ok()) << source.status();
  const auto scene = ImportGltf(**source);
  ASSERT_TRUE(scene.ok()) << scene.status();
  // The file's grid of 7 × 2 vertices lies in x = 0..6, y = 0..1; three of the upper row are lifted.
  const auto& positions = (*scene)->meshes[0].primitives[0].positions;
  ASSERT_EQ(positions.size(), 14u);
  EXPECT_EQ(positions[8], V3f(1, 2, 0));
  EXPECT_EQ(positions[10], V3f(3, 3, 0));
  EXPECT_EQ(positions[12], V3f(5, 4, 0));
  EXPECT_EQ(positions[9], V3f(2, 1, 0));
}

TEST(SharedScenes, ExternalFilesAreListedDecodedAndOnce) {
  const auto folder = FindSharedScenes();
  if (!folder.has_value()) GTEST_SKIP();
  auto source = DirectoryAssetSource::Open(*folder + "/InterpolationTest/InterpolationTest.gltf");
  ASSERT_TRUE(source.ok()) << source.status();
  const auto root = (*source)->Read("InterpolationTest.gltf", 1 << 20);
  ASSERT_TRUE(root.ok()) << root.status();
  const auto files = ListExternalFiles(**source, *root);
  ASSERT_TRUE(files.ok()) << files.status();
  EXPECT_EQ(*files, (std::vector<std::string>{"interpolation.bin", "l.jpg"}));
}

TEST(SharedScenes, TangentsAgreeWithThoseThatFilesCarry) {
  const auto folder = FindSharedScenes();
  if (!folder.has_value()) GTEST_SKIP();
  // Files store tangents by vertex, so that corners of mirrored and of degenerate triangles may be others'.
  for (const char* file :
       {"AlphaBlendModeTest/AlphaBlendModeTest.glb", "VintageDeskFan/VintageDeskFan.glb"}) {
    auto source = DirectoryAssetSource::Open(*folder + "/" + file);
    ASSERT_TRUE(source.ok()) << source.status();
    const auto scene = ImportGltf(**source);
    ASSERT_TRUE(scene.ok()) << scene.status();
    size_t corners = 0, agreeing = 0;
    for (const Mesh& mesh : (*scene)->meshes) {
      for (const MeshPrimitive& primitive : mesh.primitives) {
        if (primitive.tangents.empty()) continue;
        const Material& material = (*scene)->materials[size_t(primitive.material)];
        const std::vector<V4f> made = MakeTangents(primitive, material.normal_texture.texcoord);
        corners += made.size();
        for (size_t i = 0; i < made.size(); ++i) {
          const V4f& a = made[i];
          const V4f& b = primitive.tangents[i];
          agreeing += a.x * b.x + a.y * b.y + a.z * b.z > 0.99f && a.w == b.w;
        }
      }
    }
    EXPECT_GT(corners, 80u) << file;
    EXPECT_GT(double(agreeing), 0.95 * double(corners)) << file;
  }
}

}  // namespace
}  // namespace shutterline::engine::shared_scenes_test
