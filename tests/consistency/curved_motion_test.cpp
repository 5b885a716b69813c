#include <gtest/gtest.h>
#include <sys/resource.h>

#include <cstdio>

#include "common/image/metrics.h"
#include "tests/support/engine_frame.h"

namespace shutterline::engine {
namespace {

double UserSeconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return double(usage.ru_utime.tv_sec) + 1e-6 * double(usage.ru_utime.tv_usec);
}

struct Rendered {
  Image image;
  double seconds = 0;
};

Rendered Render(const std::shared_ptr<const Scene>& scene, RenderSettings settings, std::optional<int> degree,
                std::optional<int> pieces) {
  settings.motion_degree = degree;
  settings.motion_pieces = pieces;
  const double start = UserSeconds();
  absl::StatusOr<RenderedFrame> frame = RenderFrame(scene, 0, settings);
  EXPECT_TRUE(frame.ok()) << frame.status();
  return {std::move(frame->image), UserSeconds() - start};
}

double Rmse(const Image& a, const Image& b) {
  const absl::StatusOr<Comparison> difference = Compare(a, b);
  EXPECT_TRUE(difference.ok()) << difference.status();
  return difference->rmse;
}

/// A quarter turn in one shutter.
void ExpectQuarterTurn(const std::string& name, double shutter_close, int instants) {
  const absl::StatusOr<std::shared_ptr<const Scene>> scene = LoadTestScene(name);
  ASSERT_TRUE(scene.ok()) << scene.status();
  RenderSettings settings;
  settings.width = 128;
  settings.height = 96;
  settings.shutter_close = shutter_close;
  settings.pattern = PatternKind::k1h1v;
  // The same instants for all: what differs is the motion. Odd numbers of them, so that instants do not fall
  // on the dyadic times at which curves and straight pieces are exact alike.
  settings.time_samples = instants;
  const Rendered reference = Render(*scene, settings, 1, 64);
  const Rendered straight = Render(*scene, settings, 1, 1), parabola = Render(*scene, settings, 2, 1),
                 curved = Render(*scene, settings, 2, std::nullopt),
                 chosen = Render(*scene, settings, std::nullopt, std::nullopt);
  std::printf(
      "%s, quarter turn, RMSE against 64 straight pieces: straight %.5f, one parabola %.5f, degree 2 %.5f, "
      "as "
      "chosen %.5f; seconds %.2f %.2f %.2f %.2f, reference %.2f\n",
      name.c_str(), Rmse(straight.image, reference.image), Rmse(parabola.image, reference.image),
      Rmse(curved.image, reference.image), Rmse(chosen.image, reference.image), straight.seconds,
      parabola.seconds, curved.seconds, chosen.seconds, reference.seconds);
  EXPECT_LE(Rmse(curved.image, reference.image), 0.005);
  EXPECT_LE(Rmse(chosen.image, reference.image), 0.005);
  EXPECT_GT(Rmse(straight.image, reference.image), 0.02) << "the turn would not need curves";
}

TEST(CurvedMotion, QuarterTurnOfTheFanIsWithinTolerance) {
  ExpectQuarterTurn("fan", 1.5, 13);  // 30 degrees in half a frame.
}

TEST(CurvedMotion, QuarterTurnOfTheClothBallIsWithinTolerance) {
  ExpectQuarterTurn("clothball", 1, 3);  // 45 degrees in half a frame.
}

}  // namespace
}  // namespace shutterline::engine
