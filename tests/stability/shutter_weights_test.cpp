// Hard case 29: times weigh as much as the shutter is open.
#include <gtest/gtest.h>

#include <string>

#include "tests/support/frame_scene_builder.h"
#include "tests/support/render_tiles.h"
#include "worker/engine/render/tile_integrator.h"

namespace shutterline::engine::shutter_weights_test {
namespace {

class ShutterWeights : public testing::TestWithParam<IntegratorKind> {
 protected:
  static absl::StatusOr<std::unique_ptr<TileIntegrator>> Make(const FrameSceneBuilder& scene,
                                                              RenderSettings settings) {
    settings.width = settings.height = 64;
    settings.integrator = GetParam();
    settings.time_samples = 256;
    settings.target_error = std::nullopt;
    settings.spp = 1024;
    return MakeTileIntegrator(scene.Build(), 0, settings, 1);
  }
};
std::string IntegratorName(const testing::TestParamInfo<IntegratorKind>& parameter) {
  return std::string(ToString(parameter.param));
}
INSTANTIATE_TEST_SUITE_P(Integrators, ShutterWeights,
                         testing::Values(IntegratorKind::kLine, IntegratorKind::kReference), IntegratorName);

/// Covers pixel (30, 20) from shutter time 3/4 on: its edge crosses the pixel in a forty-thousandth of the
/// shutter. With `reversed`, until 1/4.
FrameSceneBuilder Covering(bool reversed) {
  constexpr double kSpeed = 4e4;
  FrameSceneBuilder scene(OrthographicView(64, 64));
  const double edge = reversed ? 30 + 0.25 * kSpeed : 30 - 0.75 * kSpeed;
  scene.AddRectangle(-2 * kSpeed, -10, edge, 80, 5, {}, reversed ? -kSpeed : kSpeed);
  return scene;
}

TEST_P(ShutterWeights, Row29TentShutter) {
  for (const bool reversed : {false, true}) {
    RenderSettings tent;
    tent.shutter_curve = {{0, 0}, {0.5, 2}, {1, 0}};
    const auto integrator = Make(Covering(reversed), tent);
    ASSERT_TRUE(integrator.ok()) << integrator.status();
    EXPECT_NEAR(double(RenderRect(**integrator, {30, 20, 1, 1}).At(0, 0)[3]), 0.125, 1.0 / 256);
    const auto box = Make(Covering(reversed), {});
    ASSERT_TRUE(box.ok());
    EXPECT_NEAR(double(RenderRect(**box, {30, 20, 1, 1}).At(0, 0)[3]), 0.25, 1.0 / 256);
  }
}

/// A shutter that is shut for a part of its time sees nothing then, and the picture is as bright as ever.
TEST_P(ShutterWeights, ShutInBetween) {
  RenderSettings twice;
  twice.shutter_curve = {{0, 1}, {0.2, 1}, {0.25, 0}, {0.75, 0}, {0.8, 1}, {1, 1}};
  const auto integrator = Make(Covering(false), twice);
  ASSERT_TRUE(integrator.ok());
  EXPECT_NEAR(double(RenderRect(**integrator, {30, 20, 1, 1}).At(0, 0)[3]), 0.5, 1.0 / 256);
  FrameSceneBuilder still(OrthographicView(64, 64));
  still.AddRectangle(10, 10, 50, 50, 5);
  const auto resting = Make(still, twice);
  ASSERT_TRUE(resting.ok());
  EXPECT_EQ(RenderRect(**resting, {30, 20, 1, 1}).At(0, 0)[3], 1);
}

TEST(ShutterWeightsOfRivals, AreRefused) {
  RenderSettings settings;
  settings.width = settings.height = 64;
  settings.shutter_curve = {{0, 1}, {1, 0}};
  settings.integrator = IntegratorKind::kStochastic;
  EXPECT_EQ(MakeTileIntegrator(Covering(false).Build(), 0, settings, 1).status().code(),
            absl::StatusCode::kUnimplemented);
  settings.integrator = IntegratorKind::kLine;
  settings.resolver = ResolverKind::kPaper;
  EXPECT_EQ(MakeTileIntegrator(Covering(false).Build(), 0, settings, 1).status().code(),
            absl::StatusCode::kUnimplemented);
}

}  // namespace
}  // namespace shutterline::engine::shutter_weights_test
