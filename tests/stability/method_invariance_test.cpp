// What must not change a picture, for the methods beside `slice`. Each is held to what it can give: patches
// integrate time without instants, so they are equal up to rounding where only their outlines decide, and up
// to their planes where surfaces meet; points depend on nothing but their pixel, and estimate.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "tests/stability/invariance.h"
#include "tests/support/engine_frame.h"
#include "tests/support/frame_scene_builder.h"

namespace shutterline::engine {
namespace {

using namespace invariance;

/// Where surfaces meet within a cell, patches follow their planes up to a tolerance, and rounding may decide
/// through which corners a plane is laid.
constexpr double kPlanes = 2e-3;

enum class Method { kPaper, kStochastic, kReference };

class MethodInvariance : public testing::TestWithParam<Method> {
 protected:
  static bool IsPaper() { return GetParam() == Method::kPaper; }

  /// Patches of the fan take a while.
  static RenderSettings ForScenes() { return IsPaper() ? Small(35, 22) : Small(); }

  static RenderSettings With(RenderSettings settings, int points = 16) {
    switch (GetParam()) {
      case Method::kPaper:
        settings.resolver = ResolverKind::kPaper;
        break;
      case Method::kStochastic:
        settings.integrator = IntegratorKind::kStochastic;
        break;
      case Method::kReference:
        settings.integrator = IntegratorKind::kReference;
        break;
    }
    settings.spp = points;
    return settings;
  }
};
std::string MethodName(const testing::TestParamInfo<Method>& info) {
  switch (info.param) {
    case Method::kPaper:
      return "paper";
    case Method::kStochastic:
      return "stochastic";
    case Method::kReference:
      return "reference";
  }
  return "";
}
INSTANTIATE_TEST_SUITE_P(Methods, MethodInvariance,
                         testing::Values(Method::kPaper, Method::kStochastic, Method::kReference),
                         MethodName);

TEST_P(MethodInvariance, Row25ZeroMotionIsAStill) {
  // Vertices that are said to move, by nothing, against those that are not.
  const Soup soup = RandomSoup(1, 60, 0);
  FrameSceneBuilder still(PerspectiveView(70, 45));
  for (size_t i = 0; i < 60; ++i) still.AddViewTriangle(soup.open[i], {.color = soup.colors[i]});
  const auto frame = Build(soup, InOrder(60), PerspectiveView(70, 45));
  RenderSettings settings = With(Small());
  const Image expected = Render(still.Build(), settings);
  for (const int n : {1, 3, 16}) {
    settings.time_cells = n;
    EXPECT_EQ(LargestDifference(Render(frame, settings), expected), 0) << n << " time cells";
    if (!IsPaper()) break;
  }
  const auto scene = *LoadTestScene("static");
  const Image open = Render(scene, settings);
  settings.shutter_close = settings.shutter_open;
  EXPECT_EQ(Render(scene, settings).values(), open.values());
}

TEST_P(MethodInvariance, Row26TileSizeDoesNotMatter) {
  const auto frame = Build(RandomSoup(5, 60, 0.3), InOrder(60), PerspectiveView(70, 45));
  for (const int n : {1, 2, 4}) {
    RenderSettings settings = With(Small(), 4 * n);
    settings.time_cells = n;
    const Image whole = Render(frame, settings, 32);
    // A line's ends decide how far outlines beyond it are followed, and these bear on depth within.
    for (const int size : {8, 16, 64}) {
      EXPECT_LE(LargestDifference(Render(frame, settings, size), whole), IsPaper() ? kPlanes : 0)
          << n << ", tiles of " << size;
    }
  }
}

TEST_P(MethodInvariance, Row28MirroredExchangedAndReversed) {
  constexpr int kSide = 48;
  const FrameView view = PerspectiveView(kSide, kSide);
  for (const double speed : {0.0, 0.3}) {
    SCOPED_TRACE(testing::Message() << "speed " << speed);
    const Soup soup = RandomSoup(3, 40, speed);
    RenderSettings settings = With(Small(kSide, kSide), 64);
    settings.pattern = PatternKind::k2h2v;
    const auto render = [&](const Soup& s) { return Render(Build(s, InOrder(40), view), settings); };
    const Image straight = render(soup);
    const Difference mirrored = AgainstMirrored(straight, render(soup.Mirrored()));
    const Difference exchanged = AgainstExchanged(straight, render(soup.Exchanged()));
    const Image reversed = render(soup.Reversed());
    for (const Difference& d : {mirrored, exchanged}) {
      if (IsPaper()) {
        EXPECT_LE(d.largest, speed == 0 ? 1e-5 : kPlanes);
      } else {
        EXPECT_LE(d.rms, std::pow(64, -0.75) / 2);
      }
    }
    EXPECT_LE(LargestDifference(reversed, straight), speed == 0 ? 0 : IsPaper() ? kPlanes : 0.25);
  }
}

TEST_P(MethodInvariance, Row31FarFromTheOrigin) {
  for (const char* name : {"fan", "plane"}) {
    const auto scene = *LoadTestScene(name);
    const RenderSettings settings = With(ForScenes());
    const double far = 1 << 20;
    const Image there = Render(Moved(*scene, V3d(far, -far, far), 1), settings);
    const Image here = Render(scene, settings);
    if (IsPaper()) {
      EXPECT_LE(LargestDifference(there, here), 1e-5) << name;
    } else {
      // A point beside an edge may change sides.
      int different = 0;
      for (size_t i = 0; i < here.values().size(); ++i) different += here.values()[i] != there.values()[i];
      EXPECT_LE(different, 8) << name;
    }
  }
}

TEST_P(MethodInvariance, Row32AnyScale) {
  const auto scene = *LoadTestScene("fan");
  const RenderSettings settings = With(ForScenes());
  const Image here = Render(scene, settings);
  for (const double scale : {1e-18, 1e18}) {
    const Image there = Render(Moved(*scene, V3d(0, 0, 0), scale), settings);
    if (IsPaper()) {
      EXPECT_LE(LargestDifference(there, here), kPlanes) << scale;
    } else {
      int different = 0;
      for (size_t i = 0; i < here.values().size(); ++i) different += here.values()[i] != there.values()[i];
      EXPECT_LE(different, 8) << scale;
    }
  }
}

TEST_P(MethodInvariance, Row33VerticesThatAreNotFinite) {
  const auto scene = *LoadTestScene("fan");
  const RenderSettings settings = With(ForScenes());
  const Image whole = Render(scene, settings);
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    EXPECT_EQ(Render(WithBrokenMesh(*scene, bad), settings).values(), whole.values());
  }
}

TEST_P(MethodInvariance, Row39OrderOfTrianglesAndThreads) {
  for (uint64_t seed = 1; seed <= 4; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    const Soup soup = RandomSoup(seed, 80, 0.3);
    const FrameView view = PerspectiveView(70, 45);
    const RenderSettings settings = With(Small());
    const Image image = Render(Build(soup, InOrder(80), view), settings);
    std::mt19937_64 random(seed);
    auto order = InOrder(80);
    std::shuffle(order.begin(), order.end(), random);
    // Areas are summed front to back: where surfaces meet, which come first may depend on their numbers.
    EXPECT_LE(LargestDifference(Render(Build(soup, order, view), settings), image), IsPaper() ? 1e-6 : 0);
  }
  const auto scene = *LoadTestScene(IsPaper() ? "plane" : "fan");
  const RenderSettings settings = With(Small(96, 72), 4);
  const Image one = Render(scene, settings, 1);
  for (const int threads : {2, 5}) EXPECT_EQ(Render(scene, settings, threads).values(), one.values());
}

TEST_P(MethodInvariance, Row40Furnace) {
  const Soup soup = RandomSoup(9, 200, 0.4);
  FrameSceneBuilder builder(PerspectiveView(70, 45));
  for (size_t i = 0; i < 200; ++i) builder.AddViewTriangle(soup.open[i], soup.close[i]);
  builder.AddViewTriangle({V3d(-900, -900, -90), V3d(900, -900, -90), V3d(0, 900, -90)});
  const Image image = Render(builder.Build(), With(Small()));
  for (const float value : image.values()) ASSERT_EQ(value, 1.0f);
}

}  // namespace
}  // namespace shutterline::engine
