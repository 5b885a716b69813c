// What a pattern of lines cannot see by construction, held to its bound, and how exact the place of an edge
// is far out in a large frame (hard cases 23, 24 and 43), for both resolvers.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>

#include "tests/support/frame_scene_builder.h"
#include "tests/support/render_tiles.h"
#include "worker/engine/render/tile_integrator.h"

namespace shutterline::engine::pattern_limits_test {
namespace {

class PatternLimits : public testing::TestWithParam<ResolverKind> {
 protected:
  /// Coverage of one pixel.
  static double See(const FrameSceneBuilder& scene, PatternKind pattern, int size, int x, int y) {
    RenderSettings settings;
    settings.width = size;
    settings.height = 64;
    settings.resolver = GetParam();
    settings.pattern = pattern;
    settings.target_error = std::nullopt;
    const auto integrator = MakeTileIntegrator(scene.Build(), 0, settings, 1);
    EXPECT_TRUE(integrator.ok()) << integrator.status();
    return double(RenderRect(**integrator, {x, y, 1, 1}).At(0, 0)[3]);
  }
};

std::string ResolverName(const testing::TestParamInfo<ResolverKind>& parameter) {
  return std::string(ToString(parameter.param));
}
INSTANTIATE_TEST_SUITE_P(Resolvers, PatternLimits,
                         testing::Values(ResolverKind::kSlice, ResolverKind::kPaper), ResolverName);

/// Lines of `rgls` lie where 2y - x or 2x + y is an integer; farthest from both is (0.1, 0.3) of a pixel,
/// where a square of a fifth of a pixel meets none.
TEST_P(PatternLimits, Row23SmallSquareInTheHoleOfThePattern) {
  const auto square = [](double x, double y) {
    FrameSceneBuilder scene(OrthographicView(64, 64));
    scene.AddRectangle(x - 0.1, y - 0.1, x + 0.1, y + 0.1, 5);
    return scene;
  };
  EXPECT_EQ(See(square(30.1, 20.3), PatternKind::kRgls, 64, 30, 20), 0);
  // Eight lines of either kind lie closer together than the square is wide.
  EXPECT_NEAR(See(square(30.1, 20.3), PatternKind::k8h8v, 64, 30, 20), 0.04, 0.015);
  // Anywhere in the pixel at random, it is seen as large as it is on average.
  std::mt19937 random(23);
  std::uniform_real_distribution<double> uniform(0.1, 0.9);
  double sum = 0, squares = 0;
  constexpr int kPlaces = 2000;
  for (int i = 0; i < kPlaces; ++i) {
    const double seen =
        See(square(30 + uniform(random), 20 + uniform(random)), PatternKind::kRgls, 64, 30, 20);
    sum += seen;
    squares += seen * seen;
  }
  const double mean = sum / kPlaces;
  const double deviation = std::sqrt((squares / kPlaces - mean * mean) / kPlaces);
  EXPECT_NEAR(mean, 0.04, 5 * deviation + 1e-4);
}

/// Horizontal stripes a pixel apart: horizontal lines a pixel apart see all or nothing of them, vertical and
/// turned ones the half.
TEST_P(PatternLimits, Row24StripesAsFarApartAsTheLines) {
  for (const bool on_the_lines : {false, true}) {
    FrameSceneBuilder scene(OrthographicView(64, 64));
    for (int y = 0; y < 64; ++y) {
      const double from = y + (on_the_lines ? 0.25 : 0.75);
      scene.AddRectangle(-1, from, 65, from + 0.5, 5);
    }
    EXPECT_NEAR(See(scene, PatternKind::k1h1v, 64, 30, 20), on_the_lines ? 0.75 : 0.25, 1e-3);
    EXPECT_NEAR(See(scene, PatternKind::kRgls, 64, 30, 20), 0.5, 1e-3);
    EXPECT_NEAR(See(scene, PatternKind::k8h8v, 64, 30, 20), 0.5, 1e-3);
  }
}

/// The left edge of a rectangle anywhere on lines of 16384 pixels is where it should be to 2^-10 pixels.
TEST_P(PatternLimits, Row43LinesOfSixteenThousandPixels) {
  constexpr int kWidth = 16384;
  for (uint32_t seed = 1; seed <= 32; ++seed) {
    std::mt19937 random(seed);
    const double edge = std::uniform_real_distribution<double>(0, kWidth - 1)(random);
    FrameSceneBuilder scene(OrthographicView(kWidth, 64));
    scene.AddRectangle(edge, -10, kWidth + 10, 80, 5);
    const int pixel = int(edge);
    EXPECT_NEAR(
        See(scene, PatternKind::k1h1v, kWidth, pixel, 20),
        [&] {
          // The horizontal line sees a part, the vertical one all or nothing.
          const double part = pixel + 1 - edge;
          return (part + (pixel + 0.5 > edge ? 1 : 0)) / 2;
        }(),
        0x1p-11)
        << "seed " << seed << ", edge at " << edge;
  }
}

}  // namespace
}  // namespace shutterline::engine::pattern_limits_test
