#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/support/shared_scenes.h"
#include "worker/engine/scene/directory_asset_source.h"
#include "worker/engine/scene/gltf_import.h"
#include "worker/engine/scene/scene_info.h"
#include "worker/engine/shading/shade.h"

// Frames of real files that others made: facts that hold for every one of them, and some that are known of
// single ones.
namespace shutterline::engine {
namespace {

std::shared_ptr<const Scene> Import(const std::string& path) {
  auto source = DirectoryAssetSource::Open(path);
  EXPECT_TRUE(source.ok()) << source.status();
  auto scene = ImportGltf(**source);
  EXPECT_TRUE(scene.ok()) << scene.status();
  return scene.ok() ? *scene : nullptr;
}

std::vector<std::string> SceneFiles(const std::string& folder) {
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (!entry.is_directory() || entry.path().filename() == "malformed") continue;
    for (const auto& file : std::filesystem::directory_iterator(entry.path())) {
      const auto extension = file.path().extension();
      if (extension == ".glb" || extension == ".gltf") files.push_back(file.path().string());
    }
  }
  std::sort(files.begin(), files.end());
  return files;
}

RenderSettings SmallFrame() {
  RenderSettings settings;
  settings.width = 320;
  settings.height = 240;
  return settings;
}

void ExpectDrawable(const Shader& shader, bool automatic_camera) {
  const FrameScene& frame = shader.frame();
  int64_t outside = 0, dark = 0;
  for (uint32_t i = 0; i < frame.triangles.size(); ++i) {
    const FrameTriangle& triangle = frame.triangles[i];
    const FramePrimitive& primitive = frame.primitives[triangle.primitive];
    for (const uint32_t vertex : triangle.vertices) {
      const RasterPoint p = frame.VertexAt(primitive, vertex, 0.5);
      const double x = p.x / p.w, y = p.y / p.w;
      const bool inside = p.z < p.w && x > 0 && x < frame.view.width && y > 0 && y < frame.view.height;
      outside += !inside;
    }
    const V3f color = shader.Shade(i, {1 / 3.0, 1 / 3.0}, {});
    const bool valid = color.x >= 0 && color.y >= 0 && color.z >= 0 && color.x + color.y + color.z < 100;
    dark += !valid;
  }
  EXPECT_EQ(dark, 0);
  if (automatic_camera) {
    EXPECT_EQ(outside, 0);
  }
}

TEST(SharedSceneFrames, EveryAnimationOfEverySceneIsFramedAndShaded) {
  const auto folder = FindSharedScenes();
  if (!folder.has_value()) GTEST_SKIP();
  for (const std::string& file : SceneFiles(*folder)) {
    SCOPED_TRACE(file);
    const auto scene = Import(file);
    ASSERT_NE(scene, nullptr);
    const SceneInfo info = DescribeScene(*scene);
    for (size_t clip = 0; clip < std::max<size_t>(1, scene->animations.size()); ++clip) {
      RenderSettings settings = SmallFrame();
      if (!scene->animations.empty()) settings.animation = std::to_string(clip);
      for (const int number : {0, 11}) {
        const auto frame = BuildFrameScene(scene, number, settings);
        ASSERT_TRUE(frame.ok()) << frame.status();
        EXPECT_EQ(int64_t((*frame)->triangles.size()), info.drawn_triangles);
        EXPECT_EQ((*frame)->dropped_triangles, 0);
        const auto shader = Shader::Create(*frame, settings);
        ASSERT_TRUE(shader.ok()) << shader.status();
        ExpectDrawable(*shader, info.cameras.empty());
        if (scene->animations.empty()) {
          EXPECT_EQ(DescribeFrame(**frame).primitives_by_degree[1], 0);
          break;
        }
      }
    }
  }
}

TEST(SharedSceneFrames, RodTwistMovesOnStraightLines) {
  const auto folder = FindSharedScenes();
  if (!folder.has_value()) GTEST_SKIP();
  RenderSettings settings = SmallFrame();
  settings.fps = 1;
  settings.shutter_close = 1;
  const auto frame = BuildFrameScene(Import(*folder + "/RodTwist/RodTwist.glb"), 0, settings);
  ASSERT_TRUE(frame.ok()) << frame.status();
  EXPECT_TRUE((*frame)->warnings.empty()) << (*frame)->warnings[0];
  EXPECT_EQ((*frame)->primitives[0].degree, 1);
  EXPECT_GT((*frame)->primitives[0].motion_pixels, 1);
}

TEST(SharedSceneFrames, NegativeScaleTestHasFourMirroredNodes) {
  const auto folder = FindSharedScenes();
  if (!folder.has_value()) GTEST_SKIP();
  const auto scene = Import(*folder + "/NegativeScaleTest/NegativeScaleTest.glb");
  EXPECT_EQ(DescribeScene(*scene).mirrored_nodes, 4);
}

TEST(SharedSceneFrames, WheelsOfTheMilkTruckTurnAndTheRestStands) {
  const auto folder = FindSharedScenes();
  if (!folder.has_value()) GTEST_SKIP();
  const auto scene = Import(*folder + "/CesiumMilkTruck/CesiumMilkTruck.glb");
  const auto frame = BuildFrameScene(scene, 3, SmallFrame());
  ASSERT_TRUE(frame.ok()) << frame.status();
  for (const FramePrimitive& primitive : (*frame)->primitives) {
    const std::string& mesh = scene->meshes[size_t(scene->nodes[size_t(primitive.node)].mesh)].name;
    EXPECT_EQ(primitive.degree, mesh.find("heel") != std::string::npos ? 1 : 0) << mesh;
  }
}

}  // namespace
}  // namespace shutterline::engine
