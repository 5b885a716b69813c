// Coverage with closed forms, watertightness, and what other methods say about whole scenes.
#include <gtest/gtest.h>

#include <map>

#include "tests/engine/stochastic/stochastic_test_util.h"
#include "tests/support/point_oracle.h"
#include "worker/engine/stochastic/sample_keys.h"

namespace shutterline::engine::coverage_test {
namespace {

/// Integral of the ramp that rises from 0 to 1 over [0, 1] and stays there.
double Ramp(double z) {
  return z < 0 ? 0 : z < 1 ? z * z / 2 : z - 0.5;
}

/// Mean coverage of a pixel [0, 1] by a slab of width a whose left side slides from x0 to x0 + v.
double SlabCoverage(double x0, double a, double v) {
  return (Ramp(x0 + a + v) - Ramp(x0 + a) - Ramp(x0 + v) + Ramp(x0)) / v;
}

TEST(StochasticCoverage, MovingRectangle) {
  std::mt19937 random(5);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  for (int i = 0; i < 12; ++i) {
    const double x0 = uniform(-3, 1), a = uniform(0.1, 2), v = uniform(0.5, 8), height = uniform(0.2, 1);
    SCOPED_TRACE(testing::Message() << "x0 " << x0 << " a " << a << " v " << v << " height " << height);
    FrameSceneBuilder builder(PerspectiveView(64, 64));
    builder.AddRectangle(33 + x0, 40, 33 + x0 + a, 40 + height, 1 + i, {}, v, 0);
    // Both near a cell's border and with numbers of samples that are no powers of two.
    ExpectCoverage(builder.Build(), 33, 40, height * SlabCoverage(x0, a, v), i % 2 == 0 ? 256 : 100);
  }
}

TEST(StochasticCoverage, ErrorFallsFasterThanAtRandom) {
  FrameSceneBuilder builder(PerspectiveView(64, 64));
  builder.AddTriangle({{{30, 30}, {36, 31}, {31, 37}}}, {{{29, 33}, {36, 30}, {34, 38}}});
  const auto frame = builder.Build();
  const auto error = [&](int spp) {
    double squares = 0;
    for (int y = 29; y < 39; ++y) {
      for (int x = 28; x < 38; ++x) {
        const Estimate e = EstimatePixel(frame, x, y, spp, 3, 8);
        squares += e.standard_error * e.standard_error;
      }
    }
    return std::sqrt(squares);
  };
  // Independent points divide the error by 8 if there are 64 times as many; stratified ones in three
  // dimensions by 16.
  EXPECT_LT(error(1024), error(16) / 13);
}

/// What the oracle in double precision sees at the very points that the integrator takes.
TEST(StochasticCoverage, SamplesSeeWhatTheOracleSees) {
  for (const uint32_t seed : {21u, 22u, 23u, 24u}) {
    constexpr int kSide = 40, kSpp = 16;
    const bool perspective = seed % 2 == 0;
    const auto frame = RandomFrame(seed, 40, kSide, perspective);
    const Image image = RenderTiles(*MakeStochastic(frame, kSpp), kSide, kSide);
    const StratifiedPattern pattern(0, 0, kSpp);
    int64_t different = 0, covered = 0;
    for (int y = 0; y < kSide; ++y) {
      for (int x = 0; x < kSide; ++x) {
        int count = 0;
        for (int s = 0; s < kSpp; ++s) {
          const StratifiedPoint p = pattern.At(x, y, s);
          count += SeeAt(*frame, x + double(p.x), y + double(p.y), double(p.t)).has_value();
        }
        covered += count;
        different += std::abs(count - int(std::lround(image.At(x, y)[3] * kSpp)));
      }
    }
    EXPECT_GT(covered, 1000) << "seed " << seed;
    // Samples within a rounding of an edge.
    EXPECT_LE(different, 2) << "seed " << seed;
  }
}

TEST(StochasticCoverage, ThroughTheEye) {
  // A quad that fills the picture, its plane moving from in front of the camera to behind it: what counts is
  // the time until it passes the near plane.
  constexpr double kNear = 0.1;
  FrameSceneBuilder builder(PerspectiveView(64, 64, 0.8, kNear));
  const auto corners = [](double w) {
    return std::array<V3d, 4>{V3d(-9, -9, -w), V3d(9, -9, -w), V3d(9, 9, -w), V3d(-9, 9, -w)};
  };
  const auto open = corners(1), close = corners(-1);
  builder.AddViewMesh({open.begin(), open.end()}, {close.begin(), close.end()}, {{0, 1, 2}, {0, 2, 3}});
  ExpectCoverage(builder.Build(), 20, 45, (1 - kNear) / 2, 256, 1e-4);
}

/// A closed moving mesh seen from inside: no sample finds a gap.
TEST(StochasticCoverage, ClosedMeshHasNoGaps) {
  for (const uint32_t seed : {31u, 32u, 33u}) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> jitter(-0.15, 0.15);
    FrameSceneBuilder builder(PerspectiveView(64, 64));
    // A subdivided octahedron around the camera, every vertex with a motion of its own.
    std::vector<V3d> points{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    std::vector<std::array<uint32_t, 3>> triangles{{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                                                   {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
    for (int level = 0; level < 4; ++level) {
      std::map<std::pair<uint32_t, uint32_t>, uint32_t> middles;
      const auto middle = [&](uint32_t a, uint32_t b) {
        const auto [it, is_new] = middles.try_emplace(std::minmax(a, b), uint32_t(points.size()));
        if (is_new) points.push_back((points[a] + points[b]).normalized());
        return it->second;
      };
      std::vector<std::array<uint32_t, 3>> finer;
      for (const auto& [a, b, c] : triangles) {
        const uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
        finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
      }
      triangles = finer;
    }
    std::vector<V3d> open, close;
    for (size_t i = 0; i < points.size(); ++i) {
      open.push_back(3.0 * points[i] + V3d(jitter(random), jitter(random), jitter(random)));
      // Some rest, so that resting and moving triangles share edges.
      close.push_back(i % 3 == 0 ? open[i] : open[i] + V3d(jitter(random), jitter(random), jitter(random)));
    }
    builder.AddViewMesh(open, close, triangles);
    const Image image = RenderTiles(*MakeStochastic(builder.Build(), 256, seed), 64, 64);
    for (int y = 0; y < 64; ++y) {
      for (int x = 0; x < 64; ++x) {
        ASSERT_EQ(image.At(x, y)[3], 1) << "pixel " << x << " " << y << " seed " << seed;
      }
    }
  }
}

TEST(StochasticCoverage, LowerOfCoplanarDuplicatesIsSeen) {
  for (const bool moves : {false, true}) {
    FrameSceneBuilder builder(PerspectiveView(64, 64));
    const double dx = moves ? 3 : 0;
    builder.AddRectangle(10, 10, 50, 50, 2, {.color = {1, 0, 0}}, dx, 0);
    builder.AddRectangle(10, 10, 50, 50, 2, {.color = {0, 1, 0}}, dx, 0);
    const Image image = RenderRect(*MakeStochastic(builder.Build(), 64), {20, 20, 8, 8});
    for (int i = 0; i < 64; ++i) {
      EXPECT_EQ(image.At(i % 8, i / 8)[0], 1);
      EXPECT_EQ(image.At(i % 8, i / 8)[1], 0);
    }
  }
}

}  // namespace
}  // namespace shutterline::engine::coverage_test
