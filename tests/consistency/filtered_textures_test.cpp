// Textures under a filter, looked up by points where things move and by pairs where they stand still: lines
// are as near to rays with the same filter as they are without one.
#include <gtest/gtest.h>

#include <cstdio>
#include <memory>

#include "common/image/metrics.h"
#include "tests/support/engine_frame.h"

namespace shutterline::engine {
namespace {

constexpr FrameOptions kOptions{.threads = 2};

/// Against rays at the same settings.
UnbiasedError ErrorOf(const std::shared_ptr<const Scene>& scene, const RenderSettings& settings) {
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
  return *error;
}

TEST(FilteredTextures, AreAsGoodAsUnfilteredOnes) {
  const auto scene = LoadTestScene("clothball");
  ASSERT_TRUE(scene.ok()) << scene.status();
  for (const double shutter_close : {0.0, 0.25}) {
    RenderSettings settings;
    settings.width = 64;
    settings.height = 48;
    settings.shutter_close = shutter_close;
    settings.pattern = PatternKind::k4h4v;
    settings.time_samples = 16;
    const UnbiasedError box = ErrorOf(*scene, settings);
    settings.filter = FilterKind::kBlackmanHarris;
    const UnbiasedError filtered = ErrorOf(*scene, settings);
    std::printf("clothball, shutter %.2f: filtered %s, box %s\n", shutter_close, filtered.ToString().c_str(),
                box.ToString().c_str());
    EXPECT_LE(filtered.d, box.d + 3 * (box.standard_error + filtered.standard_error));
    EXPECT_LE(filtered.d, 0.003 * 0.003 + 2 * filtered.standard_error);
  }
}

}  // namespace
}  // namespace shutterline::engine
