// Textures under a filter, looked up by points where things move and by pairs where they stand still: lines
// are as near to rays with the same filter as they are without one.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "common/image/metrics.h"
#include "tests/support/engine_frame.h"

namespace shutterline::engine {
namespace {

constexpr FrameOptions kOptions{.threads = 2};

/// The root of the mean squared error against rays at the same settings.
double ErrorOf(const std::shared_ptr<const Scene>& scene, const RenderSettings& settings) {
  RenderSettings rays = settings;
  rays.integrator = IntegratorKind::kReference;
  rays.spp = 64;
  const auto lines = RenderFrame(scene, 6, settings, kOptions);
  const auto a = RenderFrame(scene, 6, rays, kOptions);
  rays.seed = 1;
  const auto b = RenderFrame(scene, 6, rays, kOptions);
  EXPECT_TRUE(lines.ok() && a.ok() && b.ok());
  const auto error = MeasureUnbiasedError(lines->image, a->image, b->image);
  EXPECT_TRUE(error.ok()) << error.status();
  return std::sqrt(std::max(error->d, 0.0));
}

TEST(FilteredTextures, AreAsGoodAsUnfilteredOnes) {
  const auto scene = LoadTestScene("clothball");
  ASSERT_TRUE(scene.ok()) << scene.status();
  for (const double shutter_close : {0.0, 0.25}) {
    RenderSettings settings;
    settings.width = 80;
    settings.height = 60;
    settings.shutter_close = shutter_close;
    settings.pattern = PatternKind::k4h4v;
    settings.time_samples = 16;
    const double box = ErrorOf(*scene, settings);
    for (const FilterKind filter : {FilterKind::kTriangle, FilterKind::kBlackmanHarris}) {
      settings.filter = filter;
      const double filtered = ErrorOf(*scene, settings);
      std::printf("clothball, shutter %.2f, %s: RMSE %.5f, of the box %.5f\n", shutter_close,
                  std::string(ToString(filter)).c_str(), filtered, box);
      EXPECT_LE(filtered, 1.1 * box + 0.0005) << ToString(filter) << " shutter " << shutter_close;
    }
  }
}

}  // namespace
}  // namespace shutterline::engine
