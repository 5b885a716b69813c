// What must not change a picture: whole frames through pose, hierarchy and integrator.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "tests/stability/invariance.h"
#include "tests/support/engine_frame.h"
#include "tests/support/frame_scene_builder.h"
#include "tests/support/resolved_tile.h"

namespace shutterline::engine {
namespace {

using namespace invariance;

constexpr PatternKind kAllPatterns[] = {PatternKind::k1h1v, PatternKind::k2h2v,   PatternKind::k4h4v,
                                        PatternKind::k8h8v, PatternKind::k16h16v, PatternKind::kRgls};

TEST(Invariance, Row25ZeroMotionIsBitEqualForAllInstants) {
  const Soup soup = RandomSoup(1, 60, 0);
  const auto frame = Build(soup, InOrder(60), PerspectiveView(70, 45));
  for (const PatternKind pattern : kAllPatterns) {
    RenderSettings settings = Small();
    settings.pattern = pattern;
    const Image still = Render(frame, settings);
    for (const int n : {1, 3, 16, 1000}) {
      settings.time_samples = n;
      EXPECT_EQ(Render(frame, settings).values(), still.values())
          << ToString(pattern) << ", " << n << " instants";
    }
    settings.time_samples.reset();
    settings.time_step = 0.01;
    EXPECT_EQ(Render(frame, settings).values(), still.values()) << ToString(pattern);
  }
}

TEST(Invariance, Row25OpenShutterOnAStaticSceneIsAStill) {
  const auto scene = *LoadTestScene("static");
  RenderSettings settings = Small();
  const Image open = Render(scene, settings);
  settings.shutter_close = settings.shutter_open;
  EXPECT_EQ(Render(scene, settings).values(), open.values());
}

TEST(Invariance, Row26TileSizeDoesNotMatter) {
  const auto scene = *LoadTestScene("fan");
  for (const int n : {1, 2, 4}) {
    RenderSettings settings = Small(96, 72);
    settings.time_samples = n;
    const Image whole = Render(scene, settings, 1, 32);
    for (const int size : {8, 16, 64}) {
      EXPECT_LE(LargestDifference(Render(scene, settings, 1, size), whole), 1e-6) << "tiles of " << size;
    }
  }
}

TEST(Invariance, TilePartitionDoesNotMatter) {
  // Rectangles larger than the resolver takes at once are cut within the integrator.
  const auto scene = *LoadTestScene("plane");
  RenderSettings settings = Small(150, 90);
  settings.time_samples = 4;
  EXPECT_LE(LargestDifference(Render(scene, settings, 1, 150), Render(scene, settings, 1, 32)), 1e-6);
}

TEST(Invariance, Row28MirroredAndExchangedAxes) {
  // Patterns of horizontal and vertical lines are symmetric themselves: what stands still is equal up to
  // the rounding of mirrored coordinates, and what moves up to the instants that lines trade. rgls is not
  // symmetric: it is held to the error of its lines, in the mean over the frame.
  constexpr int kSide = 48;
  const FrameView view = PerspectiveView(kSide, kSide);
  for (const double speed : {0.0, 0.3}) {
    const Soup soup = RandomSoup(3, 40, speed);
    for (const PatternKind pattern : kAllPatterns) {
      SCOPED_TRACE(testing::Message() << ToString(pattern) << ", speed " << speed);
      RenderSettings settings = Small(kSide, kSide);
      settings.pattern = pattern;
      settings.time_samples = 64;
      const auto render = [&](const Soup& s) { return Render(Build(s, InOrder(40), view), settings); };
      const Image straight = render(soup);
      for (const Difference& d : {AgainstMirrored(straight, render(soup.Mirrored())),
                                  AgainstExchanged(straight, render(soup.Exchanged()))}) {
        if (pattern == PatternKind::kRgls) {
          EXPECT_LE(d.rms, 0.02);
        } else {
          EXPECT_LE(d.largest, speed == 0 ? 1e-5 : 1.0 / 64);
        }
      }
    }
  }
}

TEST(Invariance, Row28TimeReversal) {
  const Soup soup = RandomSoup(4, 40, 0.3);
  const Soup reversed = soup.Reversed();
  const FrameView view = PerspectiveView(70, 45);
  double last = 1;
  for (const int n : {16, 64, 256}) {
    RenderSettings settings = Small();
    settings.time_samples = n;
    const double difference = LargestDifference(Render(Build(soup, InOrder(40), view), settings),
                                                Render(Build(reversed, InOrder(40), view), settings));
    EXPECT_LE(difference, 1.0 / n) << n;
    last = difference;
  }
  EXPECT_LE(last, 0.004);
}

TEST(Invariance, Row31FarFromTheOrigin) {
  for (const char* name : {"fan", "plane"}) {
    const auto scene = *LoadTestScene(name);
    RenderSettings settings = Small();
    settings.time_samples = 8;
    const Image here = Render(scene, settings);
    const double far = 1 << 20;
    EXPECT_LE(LargestDifference(Render(Moved(*scene, V3d(far, -far, far), 1), settings), here), 1e-5) << name;
  }
}

TEST(Invariance, Row32AnyScale) {
  const auto scene = *LoadTestScene("fan");
  RenderSettings settings = Small();
  settings.time_samples = 8;
  const Image here = Render(scene, settings);
  for (const double scale : {1e-18, 1e18}) {
    // A camera below a scaled node: glTF takes only its position and direction from it.
    EXPECT_LE(LargestDifference(Render(Moved(*scene, V3d(0, 0, 0), scale), settings), here), 1e-5) << scale;
  }
}

TEST(Invariance, Row33VerticesThatAreNotFinite) {
  const auto scene = *LoadTestScene("fan");
  RenderSettings settings = Small();
  settings.time_samples = 8;
  const Image whole = Render(scene, settings);
  // A mesh whose vertices are not finite, in front of everything.
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    const auto broken = WithBrokenMesh(*scene, bad);
    const auto frame = BuildFrameScene(broken, 0, settings);
    ASSERT_TRUE(frame.ok()) << frame.status();
    EXPECT_EQ((*frame)->dropped_triangles, 3);
    EXPECT_FALSE((*frame)->warnings.empty());
    EXPECT_EQ(Render(broken, settings).values(), whole.values());
  }
}

TEST(Invariance, Row35StackedLayers) {
  // A million full-screen layers: only the front one is made into segments, some more are looked at.
  constexpr int kLayers = 1000000;
  std::vector<RasterPoint> vertices;
  std::vector<std::array<uint32_t, 3>> triangles;
  for (uint32_t i = 0; i < kLayers; ++i) {
    const double depth = 0.1 + 0.8 * ((i * 7919u) % kLayers) / kLayers;  // In no order.
    vertices.push_back({-50, -50, depth, 1});
    vertices.push_back({150, -50, depth, 1});
    vertices.push_back({50, 150, depth, 1});
    triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  FrameSceneBuilder builder(OrthographicView(32, 32));
  builder.AddMesh(std::move(vertices), {}, triangles);
  const auto frame = builder.Build();
  const ResolvedTile tile(*frame, {0, 0, 32, 32}, LineSettings(PatternKind::kRgls, 4));
  uint32_t front = 0;
  for (uint32_t i = 0; i < kLayers; ++i) {
    if ((i * 7919u) % kLayers == kLayers - 1) front = i;
  }
  for (int y = 0; y < 32; ++y) {
    for (int x = 0; x < 32; ++x) ASSERT_EQ(tile.Weight(x, y, front), tile.total());
  }
  EXPECT_LE(tile.stats().segments, 100 * tile.stats().lines) << "no early out";
}

TEST(Invariance, Row38WithoutPinnedInstants) {
  // A surface that moves in depth alone, and comes in front for the last tenth of the shutter: no pixel of
  // motion, and still more than one instant.
  FrameSceneBuilder builder(OrthographicView(32, 32));
  const auto layer = [](double depth) {
    return std::array<RasterPoint, 3>{RasterPoint{-50, -50, depth, 1}, RasterPoint{150, -50, depth, 1},
                                      RasterPoint{50, 150, depth, 1}};
  };
  builder.AddRasterTriangle(layer(0.5), {.color = V3f(0, 0, 0)});
  builder.AddRasterTriangle(layer(0.05), layer(0.55), {.color = V3f(1, 1, 1)});
  const Image image = Render(builder.Build(), Small(32, 32));
  EXPECT_NEAR(image.At(16, 16)[0], 0.1, 1.0 / 64);
}

TEST(Invariance, Row39OrderOfTriangles) {
  for (uint64_t seed = 1; seed <= 8; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    const Soup soup = RandomSoup(seed, 80, 0.3);
    const FrameView view = PerspectiveView(70, 45);
    RenderSettings settings = Small();
    const Image image = Render(Build(soup, InOrder(80), view), settings);
    std::mt19937_64 random(seed);
    for (int i = 0; i < 3; ++i) {
      auto order = InOrder(80);
      std::shuffle(order.begin(), order.end(), random);
      EXPECT_EQ(Render(Build(soup, order, view), settings).values(), image.values());
    }
  }
}

TEST(Invariance, Row39NumberOfThreads) {
  const auto scene = *LoadTestScene("fan");
  for (const IntegratorKind integrator : {IntegratorKind::kLine, IntegratorKind::kReference}) {
    RenderSettings settings = Small(160, 120);
    settings.integrator = integrator;
    settings.spp = 8;
    const Image one = Render(scene, settings, 1);
    for (const int threads : {2, 4, 7}) EXPECT_EQ(Render(scene, settings, threads).values(), one.values());
  }
}

TEST(Invariance, Row40Furnace) {
  // Radiance 1 all around: exactly 1 in every pixel, whatever moves.
  const V3f white(1, 1, 1);
  Soup soup = RandomSoup(9, 200, 0.4);
  FrameSceneBuilder builder(PerspectiveView(70, 45));
  for (size_t i = 0; i < 200; ++i) builder.AddViewTriangle(soup.open[i], soup.close[i], {.color = white});
  builder.AddViewTriangle({V3d(-900, -900, -90), V3d(900, -900, -90), V3d(0, 900, -90)}, {.color = white});
  const auto frame = builder.Build();
  for (const PatternKind pattern : kAllPatterns) {
    RenderSettings settings = Small();
    settings.pattern = pattern;
    const Image image = Render(frame, settings);
    for (const float value : image.values()) ASSERT_EQ(value, 1.0f) << ToString(pattern);
  }
}

}  // namespace
}  // namespace shutterline::engine
