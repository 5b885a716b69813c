// Whole pictures with and without the shading cache, of any size and for any number of threads: the same
// bits. And line samples against rays that shade through the same texels.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "common/image/metrics.h"
#include "tests/scenes/scene_generators.h"
#include "tests/support/render_tiles.h"
#include "worker/engine/render/tile_integrator.h"
#include "worker/engine/scene/gltf_import.h"
#include "worker/engine/scene/memory_asset_source.h"
#include "worker/engine/shading/shading_cache.h"

namespace shutterline::engine {
namespace {

constexpr int kWidth = 160, kHeight = 120;

std::shared_ptr<const Scene> Textured(const std::string& name) {
  scenes::SceneOptions options;
  options.textured = true;
  auto glb = scenes::GenerateGlb(name, options);
  EXPECT_TRUE(glb.ok()) << glb.status();
  auto scene = ImportGltf(MemoryAssetSource(name + ".glb", {{name + ".glb", *std::move(glb)}}));
  EXPECT_TRUE(scene.ok()) << scene.status();
  return *scene;
}

std::shared_ptr<const FrameScene> FrameOf(const std::string& name, const RenderSettings& settings) {
  auto frame = BuildFrameScene(Textured(name), 1, settings);
  EXPECT_TRUE(frame.ok()) << frame.status();
  return *frame;
}

Image Render(const std::shared_ptr<const FrameScene>& frame, const RenderSettings& settings, int threads,
             const std::shared_ptr<ShadingCache>& cache, RenderStats* stats = nullptr) {
  const auto integrator = MakeTileIntegrator(frame, 1, settings, threads, cache);
  EXPECT_TRUE(integrator.ok()) << integrator.status();
  return RenderTiles(**integrator, settings.width, settings.height, kTileSize, kTileSize, threads, stats);
}

std::shared_ptr<ShadingCache> Cache(size_t mebibytes) {
  return *ShadingCache::Create(mebibytes << 20);
}

RenderSettings Small() {
  RenderSettings settings;
  settings.width = kWidth;
  settings.height = kHeight;
  return settings;
}

TEST(ShadingCacheInFrames, ChangesNoBitWhateverItsSizeAndWhoeverShares) {
  for (const bool occluded : {false, true}) {
    RenderSettings settings = Small();
    settings.target_error = 0.02;
    if (occluded) {
      settings.occlusion.emplace().lines = 2;
      settings.occlusion->radius = 0.05;
    }
    const auto frame = FrameOf("chess", settings);
    RenderStats with, without, tight;
    const Image truth = Render(frame, settings, 1, Cache(1024), &with);
    EXPECT_GT(with.shading_hits, with.shading_requests / 2);
    const Image none = Render(frame, settings, 2, nullptr, &without);
    EXPECT_EQ(without.shading_hits, 0);
    EXPECT_EQ(without.shading_requests, with.shading_requests);
    EXPECT_TRUE(none.values() == truth.values()) << "without a cache";
    for (const int threads : {1, 2, 4}) {
      const auto cache = Cache(1);
      EXPECT_TRUE(Render(frame, settings, threads, cache, &tight).values() == truth.values()) << threads;
      // Another frame has come before, and this one again.
      EXPECT_TRUE(Render(frame, settings, threads, cache).values() == truth.values()) << threads;
    }
    // So little that most of it does not fit.
    RenderStats tiny;
    const auto cache = *ShadingCache::Create(4096);
    EXPECT_TRUE(Render(frame, settings, 2, cache, &tiny).values() == truth.values());
    EXPECT_GT(tiny.cache_overflows, 0);
  }
}

TEST(ShadingCacheInFrames, SavesShadingWhereThingsMove) {
  RenderSettings settings = Small();
  settings.target_error = 0.02;
  const auto frame = FrameOf("hall", settings);
  RenderStats stats;
  Render(frame, settings, 2, Cache(64), &stats);
  const int64_t shaded = stats.shading_requests - stats.shading_hits;
  std::printf("hall: %lld requests, %lld shadings, %.2f a pixel\n", (long long)stats.shading_requests,
              (long long)shaded, double(shaded) / (kWidth * kHeight));
  EXPECT_LT(shaded, stats.shading_requests / 4);
  EXPECT_LT(shaded, 4 * kWidth * kHeight);
}

TEST(ShadingCacheInFrames, PropagationIsCheaperAndNearly) {
  RenderSettings settings = Small();
  settings.target_error = 0.02;
  const auto frame = FrameOf("chess", settings);
  RenderStats plain, propagated;
  const Image image = Render(frame, settings, 1, Cache(64), &plain);
  settings.cache_propagate = true;
  const Image other = Render(frame, settings, 1, Cache(64), &propagated);
  EXPECT_LE(propagated.shading_requests - propagated.shading_hits,
            plain.shading_requests - plain.shading_hits);
  const auto comparison = Compare(other, image);
  ASSERT_TRUE(comparison.ok());
  EXPECT_LT(comparison->rmse, 0.01);
}

class SameTexels : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Scenes, SameTexels, testing::Values("chess", "armadillo", "clothball"),
                         [](const testing::TestParamInfo<const char*>& scene) {
                           return std::string(scene.param);
                         });

TEST_P(SameTexels, LinesAndRaysAgree) {
  RenderSettings settings = Small();
  settings.shading_rate = 1;
  settings.shutter_close = 0.25;
  settings.pattern = PatternKind::k8h8v;  // A line looks at one texel a pixel.
  const auto frame = FrameOf(GetParam(), settings);
  const Image lines = Render(frame, settings, 2, Cache(64));
  RenderSettings rays = settings;
  rays.integrator = IntegratorKind::kReference;
  rays.spp = 128;
  rays.seed = 1;
  const auto cache = Cache(64);
  const Image half_a = Render(frame, rays, 2, cache);
  rays.seed = 2;
  const Image half_b = Render(frame, rays, 2, cache);
  const auto error = MeasureUnbiasedError(lines, half_a, half_b);
  ASSERT_TRUE(error.ok()) << error.status();
  std::printf("%s: %s\n", GetParam(), error->ToString().c_str());
  EXPECT_LE(error->d, 0.005 * 0.005 + 2 * error->standard_error);
}

TEST(Occlusion, AWhiteSurfaceInEvenLightShowsHowOpenItIs) {
  RenderSettings settings = Small();
  settings.width = 64;
  settings.height = 48;
  settings.target_error = 0.05;
  settings.lighting = LightingKind::kScene;  // It has none of its own.
  settings.ambient = {1, 1, 1};
  settings.occlusion.emplace().lines = 16;
  settings.aovs = {Aov::kAmbientOcclusion};
  auto white = std::make_shared<Scene>(*Textured("chess"));
  for (Material& material : white->materials) {
    material = Material();
    material.roughness_factor = 1;
    material.metallic_factor = 0;
  }
  for (Mesh& mesh : white->meshes) {
    for (MeshPrimitive& primitive : mesh.primitives) primitive.colors.clear();
  }
  const auto frame = *BuildFrameScene(white, 1, settings);
  const auto integrator = MakeTileIntegrator(frame, 1, settings, 2, Cache(16));
  ASSERT_TRUE(integrator.ok()) << integrator.status();
  Image image(settings.width, settings.height, {"R", "G", "B", "A", "ao"});
  RenderStats stats;
  (*integrator)->Render({0, 0, settings.width, settings.height}, image.values(), stats);
  double darkest = 1, red = 0, open = 0, apart = 0;
  for (int y = 0; y < settings.height; ++y) {
    for (int x = 0; x < settings.width; ++x) {
      const float* pixel = image.At(x, y);
      // Colour is that of pieces, the AOV that of pairs, which may look at neighbouring texels.
      red += double(pixel[0]);
      open += double(pixel[4]);
      apart += std::abs(double(pixel[0] - pixel[4]));
      darkest = std::min(darkest, double(pixel[4]));
    }
  }
  EXPECT_NEAR(red / open, 1, 0.005);
  EXPECT_LT(apart / open, 0.03);
  EXPECT_LT(darkest, 0.8);
}

}  // namespace
}  // namespace shutterline::engine
