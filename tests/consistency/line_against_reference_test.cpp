// Two independent ways to one picture: line samples against rays. Errors are unbiased: the reference comes
// in two independent halves, so its own noise cancels (docs/math/line_samples.md). These are small versions
// of what docs/performance.md measures at full size.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <ostream>
#include <string>
#include <vector>

#include "common/image/metrics.h"
#include "common/image/png.h"
#include "tests/support/engine_frame.h"
#include "tests/support/shared_scenes.h"

namespace shutterline::engine {
namespace {

struct Case {
  std::string scene;  ///< A generated scene, or a file of the shared scenes.
  bool shared = false;
  int frame = 0;
  double shutter_close = 0.5;
  double fps = 24;
  TileRect window{416, 320, 160, 128};  ///< The part of the frame of 1024 × 768 that is compared.
};

void PrintTo(const Case& c, std::ostream* out) {
  *out << c.scene << ", frame " << c.frame;
}

std::string NameOf(const testing::TestParamInfo<Case>& info) {
  return std::filesystem::path(info.param.scene).stem().string();
}

class LineAgainstReference : public testing::TestWithParam<Case> {};

/// Keeps the pictures of a failure where a person can look at them.
void Save(const std::string& name, const Image& line, const Image& reference) {
  Image difference(line.width(), line.height());
  for (size_t i = 0; i < line.values().size(); ++i) {
    difference.values()[i] = i % 4 == 3 ? 1.0f : 10 * std::abs(line.values()[i] - reference.values()[i]);
  }
  const std::string prefix = testing::TempDir() + "consistency_" + name;
  EXPECT_TRUE(WritePng(prefix + "_line.png", line).ok());
  EXPECT_TRUE(WritePng(prefix + "_reference.png", reference).ok());
  EXPECT_TRUE(WritePng(prefix + "_difference_x10.png", difference).ok());
  std::fprintf(stderr, "pictures of %s: %s_*.png\n", name.c_str(), prefix.c_str());
}

TEST_P(LineAgainstReference, ErrorIsWithinTheBars) {
  const Case& c = GetParam();
  std::string path = c.scene;
  if (c.shared) {
    const auto folder = FindSharedScenes();
    if (!folder) GTEST_SKIP() << "the shared scenes are absent: " << c.scene << " is not compared";
    path = *folder + "/" + c.scene;
  }
  const auto loaded = LoadTestScene(path);
  ASSERT_TRUE(loaded.ok()) << loaded.status();
  const auto scene = WithFlatColors(**loaded);
  RenderSettings settings;
  const FrameOptions options{.threads = 2, .window = c.window};
  settings.shutter_close = c.shutter_close;
  settings.fps = c.fps;
  const auto line = RenderFrame(scene, c.frame, settings, options);
  ASSERT_TRUE(line.ok()) << line.status();
  RenderSettings reference = settings;
  reference.integrator = IntegratorKind::kReference;
  reference.spp = 256;
  reference.seed = 1;
  const auto half_a = RenderFrame(scene, c.frame, reference, options);
  reference.seed = 2;
  const auto half_b = RenderFrame(scene, c.frame, reference, options);
  ASSERT_TRUE(half_a.ok() && half_b.ok());
  const auto moving = MaskMotion(scene, c.frame, settings, options);
  ASSERT_TRUE(moving.ok());

  const auto whole = MeasureUnbiasedError(line->image, half_a->image, half_b->image);
  const auto in_motion = MeasureUnbiasedError(line->image, half_a->image, half_b->image, moving->region);
  ASSERT_TRUE(whole.ok()) << whole.status();
  ASSERT_TRUE(in_motion.ok()) << in_motion.status() << ": nothing moves";
  std::printf("%s: whole frame %s; moving region (%lld pixels) %s\n", c.scene.c_str(),
              whole->ToString().c_str(), (long long)in_motion->pixels, in_motion->ToString().c_str());
  // Two standard errors of the measurement on top of the bars.
  EXPECT_LE(whole->d, 0.01 * 0.01 + 2 * whole->standard_error);
  EXPECT_LE(in_motion->d, 0.005 * 0.005 + 2 * in_motion->standard_error);
  if (HasFailure()) Save(NameOf({GetParam(), 0}), line->image, half_a->image);
}

INSTANTIATE_TEST_SUITE_P(Generated, LineAgainstReference,
                         testing::Values(Case{.scene = "plane"}, Case{.scene = "fan"},
                                         Case{.scene = "debris"}),
                         NameOf);
INSTANTIATE_TEST_SUITE_P(Shared, LineAgainstReference,
                         testing::Values(Case{.scene = "RodTwist/RodTwist.glb",
                                              .shared = true,
                                              .shutter_close = 1,
                                              .fps = 1,
                                              .window = {128, 192, 160, 128}},
                                         Case{.scene = "CesiumMilkTruck/CesiumMilkTruck.glb",
                                              .shared = true,
                                              .frame = 2,
                                              .window = {480, 512, 160, 128}},
                                         Case{.scene = "BoxAnimated/BoxAnimated.glb",
                                              .shared = true,
                                              .frame = 36,
                                              .window = {416, 64, 192, 128}},
                                         Case{.scene = "VintageDeskFan/VintageDeskFan.glb",
                                              .shared = true,
                                              .frame = 10,
                                              .window = {384, 192, 192, 128}}),
                         NameOf);

TEST(LineIntegrator, ErrorFallsAtLeastAsOneOverTheInstants) {
  // Against itself at many instants: what is left is the error of time alone, which RGLS's four lines do
  // not hide.
  for (const char* name : {"plane", "fan", "debris"}) {
    const auto loaded = LoadTestScene(name);
    ASSERT_TRUE(loaded.ok()) << loaded.status();
    RenderSettings settings;
    settings.width = 96;
    settings.height = 72;
    settings.time_samples = 1024;
    const auto exact = RenderFrame(*loaded, 0, settings, {.threads = 2});
    ASSERT_TRUE(exact.ok());
    double sx = 0;
    double sy = 0;
    double sxx = 0;
    double sxy = 0;
    int n = 0;
    std::string errors;
    for (const int instants : {4, 8, 16, 32, 64}) {
      settings.time_samples = instants;
      const auto frame = RenderFrame(*loaded, 0, settings, {.threads = 2});
      ASSERT_TRUE(frame.ok());
      const auto comparison = Compare(frame->image, exact->image);
      ASSERT_TRUE(comparison.ok());
      errors += std::to_string(comparison->rmse) + " ";
      const double x = std::log2(instants);
      const double y = std::log2(comparison->rmse);
      ++n;
      sx += x;
      sy += y;
      sxx += x * x;
      sxy += x * y;
    }
    const double slope = (n * sxy - sx * sy) / (n * sxx - sx * sx);
    std::printf("%s: RMSE %s slope %.3f\n", name, errors.c_str(), slope);
    EXPECT_LE(slope, -1) << name << ": " << errors;
  }
}

}  // namespace
}  // namespace shutterline::engine
