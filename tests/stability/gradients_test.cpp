// Colours that vary linearly over what moves: their mean over a pixel and the shutter is known, and a pair's
// centroid has it. What is looked up in texels would be off by up to half a texel.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "tests/support/frame_scene_builder.h"
#include "tests/support/render_tiles.h"
#include "worker/engine/render/tile_integrator.h"

namespace shutterline::engine::gradients_test {
namespace {

constexpr int kSide = 64;
constexpr double kMargin = 16, kSlide = 10, kWidth = kSide + 2 * kMargin;

class Gradients : public testing::TestWithParam<ResolverKind> {};
INSTANTIATE_TEST_SUITE_P(Resolvers, Gradients, testing::Values(ResolverKind::kSlice, ResolverKind::kPaper),
                         [](const auto& parameter) { return std::string(ToString(parameter.param)); });

TEST_P(Gradients, OfUnlitColoursAreExactInMotion) {
  FrameSceneBuilder scene(OrthographicView(kSide, kSide));
  FlatLook look;
  look.vertex_colors = {{0, 0, 0, 1}, {0, 0, 0, 1}, {1, 1, 1, 1}, {1, 1, 1, 1}};  // From left to right.
  scene.AddRectangle(-kMargin, -kMargin, kSide + kMargin, kSide + kMargin, 2, look, kSlide, 0);
  RenderSettings settings;
  settings.width = settings.height = kSide;
  settings.resolver = GetParam();
  settings.time_samples = 128;
  const auto integrator = MakeTileIntegrator(scene.Build(), 0, settings, 1);
  ASSERT_TRUE(integrator.ok()) << integrator.status();
  const Image image = RenderTiles(**integrator, kSide, kSide);
  double largest = 0;
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const double truth = (x + 0.5 + kMargin - kSlide / 2) / kWidth;
      largest = std::max(largest, std::abs(double(image.At(x, y)[0]) - truth));
      ASSERT_NEAR(image.At(x, y)[3], 1, 1e-5);
    }
  }
  EXPECT_LT(largest, 5e-4);
}

}  // namespace
}  // namespace shutterline::engine::gradients_test
