// Hard cases for the integrators that look at points in (x, y, t). What points cannot miss is exact; an area
// they estimate, and each test holds the estimates to N^-0.75, which stratified points keep and independent
// ones do not, and their mean over seeds to a few standard errors.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include "tests/stability/hard_case.h"
#include "tests/support/render_tiles.h"
#include "worker/engine/render/tile_integrator.h"

namespace shutterline::engine::hard_case {
namespace {

/// Red, green and blue: the coverage by triangles of that group; then the coverage by all.
using Groups = std::array<double, 4>;

/// An estimate of `points` points in the pixel. `group` names each triangle's, all are of the first where it
/// is empty.
Groups See(const Case& c, IntegratorKind integrator, int points, uint64_t seed, const Variant& variant = {},
           const std::vector<int>& group = {}, bool perspective = false) {
  std::vector<V3f> colors;
  for (size_t i = 0; i < c.triangles.size(); ++i) {
    V3f color(0, 0, 0);
    color[group.empty() ? 0 : group[i]] = 1;
    colors.push_back(color);
  }
  const FrameView view = perspective ? PerspectiveView(64, 64, 0.8, 0.1) : OrthographicView(64, 64);
  RenderSettings settings;
  settings.width = settings.height = 64;
  settings.integrator = integrator;
  settings.spp = points;
  settings.seed = seed;
  const auto built = MakeTileIntegrator(FrameOf(c, variant, view, colors), 0, settings, 1);
  EXPECT_TRUE(built.ok()) << built.status();
  const Image pixel = RenderRect(**built, {variant.dx, variant.dy, 1, 1});
  Groups seen;
  std::copy_n(pixel.At(0, 0), 4, seen.begin());
  return seen;
}

class PointCases : public testing::TestWithParam<IntegratorKind> {
 protected:
  static constexpr int kPoints = 256;

  /// Holds the coverage by `channel` to `truth`. `slack` is for what single precision does to an edge.
  static void ExpectEstimates(const Case& c, double truth, const Variant& variant = {},
                              const std::vector<int>& group = {}, size_t channel = 3,
                              bool perspective = false, double slack = 3e-5) {
    constexpr int kSeeds = 16;
    double sum = 0;
    double squares = 0;
    for (uint64_t seed = 0; seed < kSeeds; ++seed) {
      const double error = See(c, GetParam(), kPoints, seed, variant, group, perspective)[channel] - truth;
      sum += error;
      squares += error * error;
    }
    const double mean = sum / kSeeds;
    const double variance = std::max(0.0, squares / kSeeds - mean * mean) * kSeeds / (kSeeds - 1);
    EXPECT_LE(std::sqrt(squares / kSeeds), std::pow(kPoints, -0.75)) << variant.Name();
    EXPECT_LE(std::abs(mean), 4.5 * std::sqrt(variance / kSeeds) + slack) << variant.Name();
  }
  static Groups Exactly(const Case& c, const Variant& variant = {}, const std::vector<int>& group = {}) {
    return See(c, GetParam(), kPoints, 1, variant, group);
  }
};
std::string IntegratorName(const testing::TestParamInfo<IntegratorKind>& info) {
  return std::string(ToString(info.param));
}
INSTANTIATE_TEST_SUITE_P(Integrators, PointCases,
                         testing::Values(IntegratorKind::kStochastic, IntegratorKind::kReference),
                         IntegratorName);

TEST_P(PointCases, Row01SlidingRectangle) {
  for (uint64_t seed = 1; seed <= 4; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> unit(0, 1);
    const double x0 = -4 + 3 * unit(random), a = 0.1 + unit(random), v = 1 + 5 * unit(random);
    const Variant variant = AllVariants()[seed % 8];
    ExpectEstimates(Sliding(x0, a, v), SlidingRectangle(x0, a, v), variant);
  }
}

TEST_P(PointCases, Row02VanishingMotionIsStatic) {
  for (const Variant& variant : AllVariants()) {
    EXPECT_EQ(Exactly(Sliding(0.3, 0.4, 1e-30), variant), Exactly(Sliding(0.3, 0.4, 0), variant));
  }
}

TEST_P(PointCases, Row03Bullet) {
  // A millionth of (x, y, t): points meet it one time in 4000 pixels, and are right in the mean.
  ExpectEstimates(Sliding(-1, 1e-3, 1000), SlidingRectangle(-1, 1e-3, 1000));
}

TEST_P(PointCases, Row04PivotingEdge) {
  Case c;
  c.triangles.push_back({{At(0, 0), At(1, 0), At(0, -50)}, {At(0, 0), At(1, 1), At(0, -50)}});
  c.triangles.push_back({{At(1, 0), At(1, -50), At(0, -50)}, {At(1, 1), At(1, -50), At(0, -50)}});
  for (const Variant& variant : {AllVariants()[0], AllVariants()[7]}) ExpectEstimates(c, 0.25, variant);
}

TEST_P(PointCases, Row06EdgeInThePlaneForAnInstant) {
  // The edge turns about the pixel's middle, the triangle is below it.
  Case c;
  c.triangles.push_back({{At(0, 1), At(1, 0), At(0.5, -5000)}, {At(0, 0), At(1, 1), At(0.5, -5000)}});
  ExpectEstimates(c, 0.5, {}, {}, 3, false, 2e-4);
}

TEST_P(PointCases, Row07And08SharedEdgesAndAFansHub) {
  Case edge;
  edge.triangles.push_back({{At(-9, 0.5), At(9, 0.5), At(0, 30)}, {At(-4, 0.5), At(14, 0.5), At(5, 30)}});
  edge.triangles.push_back({{At(9, 0.5), At(-9, 0.5), At(0, -30)}, {At(14, 0.5), At(-4, 0.5), At(5, -30)}});
  EXPECT_EQ(Exactly(edge)[3], 1);
  for (uint64_t seed = 1; seed <= 8; ++seed) {
    std::mt19937_64 random(seed);
    const int blades = 3 + int(random() % 20);
    const double turn = std::uniform_real_distribution<double>(0, 1)(random);
    Case fan;
    const auto hub = [&](double t) { return At(0.3 + 0.4 * t, 0.5); };
    const auto rim = [&](int i, double t) {
      const double angle = 2 * M_PI * (i + turn * t) / blades;
      return At(0.5 + 40 * std::cos(angle), 0.5 + 40 * std::sin(angle));
    };
    for (int i = 0; i < blades; ++i) {
      const int j = (i + 1) % blades;
      fan.triangles.push_back({{hub(0), rim(i, 0), rim(j, 0)}, {hub(1), rim(i, 1), rim(j, 1)}});
    }
    EXPECT_EQ(Exactly(fan)[3], 1) << "seed " << seed;
  }
}

TEST_P(PointCases, Row09EdgeOnTriangle) {
  for (uint64_t seed = 1; seed <= 8; ++seed) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> unit(0, 1);
    const double slope = 4 * unit(random) - 2;
    const auto on_line = [&](double x, double t, double d) { return At(x, 0.3 + slope * x + 0.2 * t, d); };
    const double x[3] = {-2 * unit(random), 1 + unit(random), unit(random)};
    Case c;
    c.triangles.push_back({{on_line(x[0], 0, 0.9), on_line(x[1], 0, 0.8), on_line(x[2], 0, 0.7)},
                           {on_line(x[0], 1, 0.9), on_line(x[1], 1, 0.8), on_line(x[2], 1, 0.7)}});
    AddRectangle(c, -3, -3, 3, 3, 0, 0, 0.5);
    const Groups seen = Exactly(c, {}, {0, 1, 1});
    EXPECT_EQ(seen[0], 0) << "seed " << seed;
    EXPECT_EQ(seen[1], 1) << "seed " << seed;
  }
}

TEST_P(PointCases, Row10FacingFlip) {
  for (const double a : {0.2, 1.0}) {
    Case c;
    const auto corners = [&](double w) -> std::array<RasterPoint, 4> {
      return {At(0.5 - w / 2, -50), At(0.5 - w / 2, 50), At(0.5 + w / 2, 50), At(0.5 + w / 2, -50)};
    };
    AddQuad(c, corners(a), corners(-a));
    for (const Variant& variant : {AllVariants()[0], AllVariants()[3], AllVariants()[5]}) {
      c.double_sided = true;
      ExpectEstimates(c, a / 2, variant);
      c.double_sided = false;
      ExpectEstimates(c, a / 4, variant);
    }
  }
}

TEST_P(PointCases, Row11DegenerateTriangles) {
  Case c;
  const RasterPoint p = At(0.25, 0.5);
  const RasterPoint q = At(0.75, 1);
  c.triangles.push_back({{p, p, p}, {q, q, q}});
  c.triangles.push_back({{p, q, p}, {q, q, p}});
  c.triangles.push_back({{p, q, At(0.5, 0.75)}, {p, q, At(0.5, 0.75)}});
  for (const Variant& variant : AllVariants()) EXPECT_EQ(Exactly(c, variant)[3], 0) << variant.Name();
}

TEST_P(PointCases, Row12ApproachToTheNearPlane) {
  const double near = 0.1;  // Of the view; z is the near distance everywhere.
  Case c;
  const auto corner = [&](double x, double y, double w) -> RasterPoint {
    return {x * 100, y * 100, near, w};
  };
  AddQuad(c, {corner(-1, -1, 1), corner(1, -1, 1), corner(1, 1, 1), corner(-1, 1, 1)},
          {corner(-1, -1, -1), corner(1, -1, -1), corner(1, 1, -1), corner(-1, 1, -1)});
  // Strata of time are as many as points: the estimate is off by one of them at most.
  const double seen = See(c, GetParam(), kPoints, 1, {}, {}, true)[3];
  EXPECT_NEAR(seen, (1 - near) / 2, 1.01 / kPoints);
}

TEST_P(PointCases, Row15PerspectiveArea) {
  const double h = 1.5;
  Case c;
  const auto corners = [&](double w) -> std::array<RasterPoint, 4> {
    return {RasterPoint{-50, -50, 0.1, w}, RasterPoint{h, -50, 0.1, w}, RasterPoint{h, 50, 0.1, w},
            RasterPoint{-50, 50, 0.1, w}};
  };
  AddQuad(c, corners(1), corners(2));
  for (const Variant& variant : {AllVariants()[0], AllVariants()[6]}) {
    ExpectEstimates(c, h - 1 + h * std::log(2 / h), variant, {}, 3, true);
  }
}

TEST_P(PointCases, Row16DepthBilinearInPositionAndTime) {
  Case c;
  AddRectangle(c, -1, -50, 2, 50, 0, 0, 0.5);
  const auto b = [](double x, double y, double t) { return At(x, y, 1 - x * t); };
  AddQuad(c, {b(0, -50, 0), b(1, -50, 0), b(1, 50, 0), b(0, 50, 0)},
          {b(0, -50, 1), b(1, -50, 1), b(1, 50, 1), b(0, 50, 1)});
  ExpectEstimates(c, 0.5 + 0.5 * std::log(2), {}, {0, 0, 1, 1}, 1);
}

TEST_P(PointCases, Row18DepthsThatCrossOnTheLine) {
  Case c;
  const auto level = [](double at_0, double at_1) -> std::array<RasterPoint, 4> {
    return {At(0, -50, at_0), At(1, -50, at_1), At(1, 50, at_1), At(0, 50, at_0)};
  };
  AddQuad(c, level(0.2, 0.8), level(0.2, 0.8));
  AddQuad(c, level(0.8, 0.2), level(0.8, 0.2));
  for (const size_t channel : {0u, 1u}) ExpectEstimates(c, 0.5, {}, {0, 0, 1, 1}, channel);
}

TEST_P(PointCases, Row22TJunctionShowsItsGap) {
  const double delta = 0.25;
  Case c;
  const auto still = [&](RasterPoint p, RasterPoint q, RasterPoint r) {
    c.triangles.push_back({{p, q, r}, {p, q, r}});
  };
  still(At(0, -50), At(0.5, -50), At(0.5, 50));
  still(At(0, -50), At(0.5, 50), At(0, 50));
  still(At(0.5, -1), At(2, 0.5), At(0.5 + delta, 0.5));
  still(At(0.5, 2), At(0.5 + delta, 0.5), At(2, 0.5));
  still(At(0.5, -1), At(2, -1), At(2, 0.5));
  still(At(0.5, 2), At(2, 0.5), At(2, 2));
  ExpectEstimates(c, 1 - delta * (1 - 0.25 / 1.5));
}

TEST_P(PointCases, Row36SmallTrianglesHideJointly) {
  Case c;
  std::vector<int> group;
  for (int i = 0; i < 8; ++i) {
    for (int j = 0; j < 4; ++j) AddRectangle(c, i / 8.0, j / 4.0, (i + 1) / 8.0, (j + 1) / 4.0, 0, 0, 0.8);
  }
  group.assign(c.triangles.size(), 0);
  AddRectangle(c, -1, -1, 2, 2, 0.5, 0, 0.2);
  group.resize(c.triangles.size(), 1);
  const Groups seen = Exactly(c, {}, group);
  EXPECT_EQ(seen[0], 1);
  EXPECT_EQ(seen[1], 0);
}

TEST_P(PointCases, Row37HoleOfAThousandth) {
  Case c;
  const double x = 0.3718;
  AddRectangle(c, -5, -5, x, 5, 0, 0, 0.8);
  AddRectangle(c, x + 1e-3, -5, 5, 5, 0, 0, 0.8);
  AddRectangle(c, -5, -5, 5, 5, 1, 1, 0.2);
  ExpectEstimates(c, 1e-3, {}, {0, 0, 0, 0, 1, 1}, 1);
  EXPECT_EQ(Exactly(c)[3], 1);
}

TEST_P(PointCases, Row35StackedLayers) {
  // A million red layers in no order, a green one before them all.
  constexpr uint32_t kLayers = 1000000;
  std::vector<RasterPoint> vertices;
  std::vector<std::array<uint32_t, 3>> triangles;
  const auto add = [&](double depth) {
    const auto first = uint32_t(vertices.size());
    for (const auto& [x, y] : {std::pair(-50, -50), std::pair(150, -50), std::pair(50, 150)}) {
      vertices.push_back({double(x), double(y), depth, 1});
    }
    triangles.push_back({first, first + 1, first + 2});
  };
  for (uint32_t i = 0; i < kLayers; ++i) add(0.1 + 0.8 * ((i * 7919u) % kLayers) / kLayers);
  FrameSceneBuilder builder(OrthographicView(64, 64));
  builder.AddMesh(std::move(vertices), {}, triangles, {.color = {1, 0, 0}});
  vertices.clear();
  triangles.clear();
  add(0.95);
  builder.AddMesh(std::move(vertices), {}, triangles, {.color = {0, 1, 0}});
  RenderSettings settings;
  settings.width = settings.height = 64;
  settings.integrator = GetParam();
  settings.spp = 16;
  const auto built = MakeTileIntegrator(builder.Build(), 0, settings, 2);
  ASSERT_TRUE(built.ok()) << built.status();
  const Image pixels = RenderRect(**built, {16, 16, 8, 8});
  for (int i = 0; i < 8; ++i) {
    EXPECT_EQ(pixels.At(i, i)[0], 0);
    EXPECT_EQ(pixels.At(i, i)[1], 1);
    EXPECT_EQ(pixels.At(i, i)[3], 1);
  }
}

TEST_P(PointCases, Row38BackInFrontForATenth) {
  Case c;
  AddRectangle(c, -1, -1, 2, 2, 0, 0, 0.5);
  const auto at = [](double depth) -> std::array<RasterPoint, 4> {
    return {At(-1, -1, depth), At(2, -1, depth), At(2, 2, depth), At(-1, 2, depth)};
  };
  AddQuad(c, at(0.05), at(0.55));
  for (const Variant& variant : {AllVariants()[0], AllVariants()[7]}) {
    const Groups seen = Exactly(c, variant, {0, 0, 1, 1});
    EXPECT_NEAR(seen[1], 0.1, 1.01 / kPoints);
    EXPECT_EQ(seen[3], 1);
  }
}

TEST_P(PointCases, Row42TouchesTheTileForAnInstant) {
  for (const double vx : {1.0, -1.0}) {
    Case c;
    AddRectangle(c, vx > 0 ? -6 : -5, -5, vx > 0 ? -1 : 0, 5, vx, 0);
    EXPECT_EQ(Exactly(c)[3], 0);
  }
}

}  // namespace
}  // namespace shutterline::engine::hard_case
