// Surfaces that let light through (hard case 41 and its relatives), by the line integrator and by rays.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>

#include "tests/support/frame_scene_builder.h"
#include "tests/support/render_tiles.h"
#include "tests/support/rounds.h"
#include "worker/engine/render/tile_integrator.h"

namespace shutterline::engine::layers_test {
namespace {

constexpr int kSide = 64;

FlatLook Glass(const V3f& color, float alpha) {
  FlatLook look;
  look.color = color;
  look.alpha = alpha;
  look.alpha_mode = AlphaMode::kBlend;
  return look;
}

Image Render(const FrameSceneBuilder& scene, RenderSettings settings) {
  settings.width = settings.height = kSide;
  const auto integrator = MakeTileIntegrator(scene.Build(), 0, settings, 1);
  EXPECT_TRUE(integrator.ok()) << integrator.status();
  return RenderTiles(**integrator, kSide, kSide);
}

/// Fixed instants, so that what is computed is known.
RenderSettings Lines(int instants = 8) {
  RenderSettings settings;
  settings.time_samples = instants;
  return settings;
}

RenderSettings Rays(int spp) {
  RenderSettings settings;
  settings.integrator = IntegratorKind::kReference;
  settings.spp = spp;
  return settings;
}

class Layers : public testing::TestWithParam<IntegratorKind> {
 protected:
  static RenderSettings Method() { return GetParam() == IntegratorKind::kLine ? Lines() : Rays(16); }
};
std::string IntegratorName(const testing::TestParamInfo<IntegratorKind>& parameter) {
  return std::string(ToString(parameter.param));
}
INSTANTIATE_TEST_SUITE_P(Integrators, Layers,
                         testing::Values(IntegratorKind::kLine, IntegratorKind::kReference), IntegratorName);

TEST_P(Layers, Row41HalfTransparentLayersLeaveAPowerOfTwo) {
  for (const double slide : {0.0, 20.0}) {
    for (int layers = 1; layers <= 16; ++layers) {
      FrameSceneBuilder scene(PerspectiveView(kSide, kSide));
      for (int i = 0; i < layers; ++i) {
        scene.AddRectangle(-100, -100, 200, 200, 1 + 0.5 * i, Glass(V3f(1, 0.5f, 0), 0.5f), slide);
      }
      const Image image = Render(scene, Method());
      const auto covered = float(1 - std::exp2(-layers));
      for (const auto& [x, y] : {std::pair(0, 0), std::pair(33, 17), std::pair(63, 63)}) {
        EXPECT_EQ(image.At(x, y)[3], covered) << layers << " layers, slide " << slide;
        EXPECT_NEAR(image.At(x, y)[0], covered, 1e-6);
        EXPECT_NEAR(image.At(x, y)[1], covered / 2, 1e-6);
      }
    }
  }
}

TEST_P(Layers, WhatIsOpaqueBehindMakesThePixelFull) {
  FrameSceneBuilder scene(PerspectiveView(kSide, kSide));
  scene.AddRectangle(-100, -100, 200, 200, 9, {.color = {0, 0, 1}});
  scene.AddRectangle(-100, -100, 200, 200, 4, Glass(V3f(0, 1, 0), 0.25f), 7);
  scene.AddRectangle(-100, -100, 200, 200, 2, Glass(V3f(1, 0, 0), 0.5f), -12);
  // Hidden behind what is opaque: it must not show.
  scene.AddRectangle(-100, -100, 200, 200, 12, Glass(V3f(1, 1, 1), 0.9f));
  const Image image = Render(scene, Method());
  for (int i = 0; i < kSide; ++i) {
    EXPECT_EQ(image.At(i, i)[3], 1);
    EXPECT_NEAR(image.At(i, i)[0], 0.5, 1e-6);
    EXPECT_NEAR(image.At(i, i)[1], 0.5 * 0.25, 1e-6);
    EXPECT_NEAR(image.At(i, i)[2], 0.5 * 0.75, 1e-6);
  }
}

TEST_P(Layers, AlphaOneIsOpaqueAndAlphaZeroIsNothing) {
  FrameSceneBuilder scene(PerspectiveView(kSide, kSide));
  scene.AddRectangle(-100, -100, 200, 200, 9, Glass(V3f(0, 0, 1), 1));
  scene.AddRectangle(-100, -100, 200, 200, 2, Glass(V3f(1, 0, 0), 0));
  FlatLook gone = {.color = {1, 1, 1}};
  gone.alpha = 0.4f;
  gone.alpha_mode = AlphaMode::kMask;
  scene.AddRectangle(-100, -100, 200, 200, 1, gone);
  const Image image = Render(scene, Method());
  EXPECT_EQ(image.At(20, 40)[0], 0);
  EXPECT_EQ(image.At(20, 40)[2], 1);
  EXPECT_EQ(image.At(20, 40)[3], 1);
}

/// Two sheets that cross along a vertical line, x = 32 at mid-shutter: each is in front on one side. The
/// first is seen through nothing or through the second.
TEST_P(Layers, SheetsThatCrossAreInOrderOnEitherSide) {
  FrameSceneBuilder scene(OrthographicView(kSide, kSide));
  const auto sheet = [&](double left, double right, const FlatLook& look) {
    scene.AddQuad(
        {Corner{-10, -10, left}, Corner{74, -10, right}, Corner{74, 74, right}, Corner{-10, 74, left}}, look);
  };
  sheet(10, 20, Glass(V3f(1, 0, 0), 0.5f));
  sheet(20, 10, Glass(V3f(0, 1, 0), 0.5f));
  const Image image = Render(scene, Method());
  for (int y = 0; y < kSide; y += 7) {
    EXPECT_NEAR(image.At(31, y)[0], 0.5, 1e-5);
    EXPECT_NEAR(image.At(31, y)[1], 0.25, 1e-5);
    EXPECT_NEAR(image.At(32, y)[0], 0.25, 1e-5);
    EXPECT_NEAR(image.At(32, y)[1], 0.5, 1e-5);
  }
}

/// A cut-out with alpha from 0 at the left to 1 at the right of 40 pixels, cut at c: what lies right of 40 c
/// is there, to a part of a pixel.
TEST(Layers, CutOutsAreAreasAndNotSamples) {
  for (uint32_t seed = 1; seed <= 32; ++seed) {
    std::mt19937 random(seed);
    const float cutoff = std::uniform_real_distribution<float>(0.1f, 0.9f)(random);
    FlatLook look = {.color = {1, 1, 1}};
    look.alpha_mode = AlphaMode::kMask;
    look.alpha_cutoff = cutoff;
    look.vertex_colors = {V4f(1, 1, 1, 0), V4f(1, 1, 1, 1), V4f(1, 1, 1, 1), V4f(1, 1, 1, 0)};
    FrameSceneBuilder scene(OrthographicView(kSide, kSide));
    scene.AddQuad({Corner{10, 10, 5}, Corner{50, 10, 5}, Corner{50, 50, 5}, Corner{10, 50, 5}}, look);
    const Image image = Render(scene, Lines());
    double seen = 0;
    for (int x = 0; x < kSide; ++x) {
      seen += double(image.At(x, 30)[3]);
      const double whole = std::clamp(x + 1 - (10 + 40.0 * double(cutoff)), 0.0, 1.0);
      if (x < 50) {
        EXPECT_NEAR(image.At(x, 30)[3], x < 10 ? 0 : whole, 0.01) << "seed " << seed << ", pixel " << x;
      }
    }
    EXPECT_NEAR(seen, 40 * (1 - double(cutoff)), 0.01) << "seed " << seed;
  }
}

/// A layer that covers the pixel for part of the shutter dims it for that part.
TEST(Layers, ALayerThatPassesDimsForAsLongAsItPasses) {
  FrameSceneBuilder scene(OrthographicView(kSide, kSide));
  scene.AddRectangle(-10, -10, 80, 80, 9, {.color = {1, 1, 1}});
  // Its right edge goes from 20 to 40: over pixel 29, which it reaches at mid-shutter, for about half of it.
  scene.AddRectangle(-100, -10, 20, 80, 3, Glass(V3f(0, 0, 0), 0.5f), 20);
  RenderSettings settings = Lines(256);
  settings.pattern = PatternKind::k4h4v;
  const Image image = Render(scene, settings);
  for (const int x : {22, 29, 37}) {
    const double covered = 1 - (x + 0.5 - 20) / 20;
    EXPECT_NEAR(image.At(x, 30)[0], 1 - 0.5 * covered, 2e-3) << x;
    EXPECT_EQ(image.At(x, 30)[3], 1);
  }
}

/// Random soups of triangles, layers among them, some moving: lines and rays see the same.
TEST(Layers, LinesAgreeWithRays) {
  for (uint32_t seed = 1; seed <= uint32_t(Rounds(12)); ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform;
    FrameSceneBuilder scene(PerspectiveView(kSide, kSide));
    for (int i = 0; i < 24; ++i) {
      const auto point = [&](double spread, double x, double y, double distance) {
        return Corner{x + spread * (uniform(random) - 0.5), y + spread * (uniform(random) - 0.5),
                      distance + 2 * uniform(random)};
      };
      const double x = kSide * uniform(random), y = kSide * uniform(random),
                   distance = 2 + 8 * uniform(random);
      const std::array<Corner, 3> open{point(50, x, y, distance), point(50, x, y, distance),
                                       point(50, x, y, distance)};
      std::array<Corner, 3> close = open;
      if (i % 3 == 0) {
        const double dx = 16 * uniform(random) - 8;
        for (Corner& corner : close) corner.x += dx;
      }
      FlatLook look = {.color = V3f(float(uniform(random)), float(uniform(random)), float(uniform(random)))};
      if (i % 4 != 0) {
        look.alpha = float(uniform(random));
        look.alpha_mode = AlphaMode::kBlend;
      }
      scene.AddTriangle(open, close, look);
    }
    RenderSettings lines = Lines(64);
    lines.pattern = PatternKind::k8h8v;
    const Image a = Render(scene, lines), b = Render(scene, Rays(1024));
    double squares = 0;
    for (size_t i = 0; i < a.values().size(); ++i) {
      squares += std::pow(double(a.values()[i]) - double(b.values()[i]), 2);
    }
    EXPECT_LT(std::sqrt(squares / double(a.values().size())), 0.004) << "seed " << seed;
  }
}

/// Where tiles are cut must not show.
TEST(Layers, TilesAgree) {
  FrameSceneBuilder scene(PerspectiveView(kSide, kSide));
  scene.AddRectangle(5, 8, 50, 60, 9, {.color = {0, 0.5f, 1}}, 5);
  scene.AddRectangle(10, 2, 40, 62, 4, Glass(V3f(0, 1, 0), 0.3f), 7);
  scene.AddRectangle(20, 20, 60, 44, 2, Glass(V3f(1, 0, 0), 0.6f));
  RenderSettings settings = Lines();
  settings.width = settings.height = kSide;
  const auto integrator = MakeTileIntegrator(scene.Build(), 0, settings, 1);
  ASSERT_TRUE(integrator.ok());
  const Image whole = RenderTiles(**integrator, kSide, kSide, kSide, kSide);
  for (const int side : {8, 16, 32}) {
    const Image cut = RenderTiles(**integrator, kSide, kSide, side, side, 2);
    for (size_t i = 0; i < whole.values().size(); ++i) {
      ASSERT_NEAR(whole.values()[i], cut.values()[i], 1e-6) << "tiles of " << side;
    }
  }
}

}  // namespace
}  // namespace shutterline::engine::layers_test
