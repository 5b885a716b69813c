// Hard cases of coverage: what must be exact, whatever the number of instants.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "tests/stability/hard_case.h"
#include "tests/support/rounds.h"

namespace shutterline::engine::hard_case::coverage_test {
namespace {

constexpr PatternKind kSymmetric[] = {PatternKind::k1h1v, PatternKind::k2h2v, PatternKind::k4h4v,
                                      PatternKind::k8h8v, PatternKind::k16h16v};
constexpr PatternKind kAllPatterns[] = {PatternKind::k1h1v, PatternKind::k2h2v,   PatternKind::k4h4v,
                                        PatternKind::k8h8v, PatternKind::k16h16v, PatternKind::kRgls};

using Coverage = EachResolver;
INSTANTIATE_TEST_SUITE_P(Resolvers, Coverage, testing::Values(ResolverKind::kSlice, ResolverKind::kPaper),
                         ResolverName);

TEST(CoverageOfALine, Row05EdgeParallelToTheLine) {
  // f0 = 1 − t, f1 = t: above the line at all times, parallel to it at ½. The third vertex is above too.
  Case c;
  c.triangles.push_back(
      {{At(0.2, 0.5 + 1), At(0.8, 0.5 + 0), At(0.5, 3)}, {At(0.2, 0.5 + 0), At(0.8, 0.5 + 1), At(0.5, 3)}});
  for (const int n : {1, 2, 3, 1024}) {
    const double seen = LineCoverage(c, 0.5, n);
    EXPECT_TRUE(std::isfinite(seen));
    EXPECT_EQ(seen, 0) << n;
  }
}

TEST(CoverageOfALine, Row06EdgeInThePlaneForAnInstant) {
  // The edge turns about the point l = ½ of the line and lies in its plane at t = ½; the triangle is below
  // it. Its half of the line changes sides, its length does not.
  Case c;
  c.triangles.push_back({{At(0, 0.5 + 0.5), At(1, 0.5 - 0.5), At(0.5, -1e9)},
                         {At(0, 0.5 - 0.5), At(1, 0.5 + 0.5), At(0.5, -1e9)}});
  for (const int n : {2, 16, 64, 1024}) EXPECT_NEAR(LineCoverage(c, 0.5, n), 0.5, 1e-6) << n;
  // At the very instant the rule for f = 0 decides: all of it or nothing, but a number.
  const double at_half = LineCoverage(c, 0.5, 1);
  EXPECT_TRUE(at_half == 0 || std::abs(at_half - 1) < 1e-6) << at_half;
}

TEST_P(Coverage, Row07SharedEdgeOnTheLine) {
  // Two triangles share an edge that slides along a line sample. The line belongs to one of them.
  for (const double y : {0.125, 0.25, 0.375, 0.5, 0.75}) {
    Case c;
    c.triangles.push_back({{At(-9, y), At(9, y), At(0, 30)}, {At(-4, y), At(14, y), At(5, 30)}});
    c.triangles.push_back({{At(9, y), At(-9, y), At(0, -30)}, {At(14, y), At(-4, y), At(5, -30)}});
    for (const PatternKind pattern : kAllPatterns) {
      for (const int n : {1, 7, 64}) {
        const Answer answer = See(c, pattern, n);
        EXPECT_EQ(answer.sum, 1) << ToString(pattern) << ", y = " << y;
        EXPECT_EQ(answer.background, 0) << ToString(pattern) << ", y = " << y;
      }
    }
    EXPECT_EQ(LineCoverage(c, y, 33), 1) << "counted twice or not at all";
  }
}

TEST_P(Coverage, Row08FanVertexOnTheLine) {
  for (uint64_t seed = 1; seed <= uint64_t(Rounds(32)); ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> unit(0, 1);
    const int blades = 3 + int(random() % 20);
    // The hub slides along y = ½ (a line of 1h1v), the rim turns.
    const double turn = unit(random);
    Case c;
    const auto hub = [&](double t) { return At(0.3 + 0.4 * t, 0.5); };
    const auto rim = [&](int i, double t) {
      const double angle = 2 * M_PI * (i + turn * t) / blades;
      return At(0.5 + 40 * std::cos(angle), 0.5 + 40 * std::sin(angle));
    };
    for (int i = 0; i < blades; ++i) {
      const int j = (i + 1) % blades;
      c.triangles.push_back({{hub(0), rim(i, 0), rim(j, 0)}, {hub(1), rim(i, 1), rim(j, 1)}});
    }
    for (const PatternKind pattern : kAllPatterns) {
      if (pattern == PatternKind::k16h16v && seed % 4 != 0) continue;  // Half of all the lines.
      EXPECT_EQ(See(c, pattern, 31).sum, 1) << ToString(pattern);
    }
    EXPECT_NEAR(LineCoverage(c, 0.5, 31), 1, 1e-12);
  }
}

TEST_P(Coverage, Row09EdgeOnTriangle) {
  // Projected onto a slanted straight line at all times, in front of a wall.
  for (uint64_t seed = 1; seed <= 32; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> unit(0, 1);
    const double slope = 4 * unit(random) - 2;
    const auto on_line = [&](double x, double t, double d) { return At(x, 0.3 + slope * x + 0.2 * t, d); };
    Case c;
    const double x[3] = {-2 * unit(random), 1 + unit(random), unit(random)};
    c.triangles.push_back({{on_line(x[0], 0, 0.9), on_line(x[1], 0, 0.8), on_line(x[2], 0, 0.7)},
                           {on_line(x[0], 1, 0.9), on_line(x[1], 1, 0.8), on_line(x[2], 1, 0.7)}});
    AddRectangle(c, -3, -3, 3, 3, 0, 0, 0.5);
    const Answer answer = See(c, PatternKind::kRgls, 64);
    EXPECT_LE(answer.coverage[0], 1e-6);
    EXPECT_GE(answer.coverage[1] + answer.coverage[2], 1 - 1e-6);
    EXPECT_EQ(answer.background, 0);
  }
}

TEST_P(Coverage, Row10FacingFlip) {
  // A quad of width a·|1 − 2t| turns over at t = ½.
  for (const double a : {0.2, 0.7, 1.0}) {
    Case c;
    const auto corners = [&](double w) -> std::array<RasterPoint, 4> {
      return {At(0.5 - w / 2, -50), At(0.5 - w / 2, 50), At(0.5 + w / 2, 50), At(0.5 + w / 2, -50)};
    };
    AddQuad(c, corners(a), corners(-a));
    for (const Variant& variant : VariantsThatKeepLines()) {
      SCOPED_TRACE(variant.Name());
      c.double_sided = true;
      EXPECT_NEAR(See(c, PatternKind::kRgls, 64, variant).sum, a / 2, 1e-4);
      c.double_sided = false;
      EXPECT_NEAR(See(c, PatternKind::kRgls, 64, variant).sum, a / 4, 1.0 / 64);
      EXPECT_NEAR(See(c, PatternKind::kRgls, 4096, variant).sum, a / 4, 1e-3);
    }
  }
}

TEST_P(Coverage, Row10FrontIsCounterClockwiseAsSeen) {
  // Counter-clockwise to the eye, y down in raster space: left, bottom, right.
  Case c{.triangles = {}, .double_sided = false};
  const MovingTriangle front{{At(-50, -40), At(0, 60), At(50, -40)}, {At(-50, -40), At(0, 60), At(50, -40)}};
  c.triangles = {front};
  for (const PatternKind pattern : kAllPatterns) EXPECT_EQ(See(c, pattern, 1).sum, 1) << ToString(pattern);
  std::swap(c.triangles[0].open[1], c.triangles[0].open[2]);
  std::swap(c.triangles[0].close[1], c.triangles[0].close[2]);
  for (const PatternKind pattern : kAllPatterns) EXPECT_EQ(See(c, pattern, 1).sum, 0) << ToString(pattern);
}

TEST_P(Coverage, Row11DegenerateTriangles) {
  Case c;
  const RasterPoint p = At(0.3, 0.4);
  const RasterPoint q = At(0.9, 0.8);
  c.triangles.push_back({{p, p, p}, {q, q, q}});
  c.triangles.push_back({{p, q, p}, {q, q, p}});
  c.triangles.push_back({{p, q, At(0.6, 0.6)}, {p, q, At(0.6, 0.6)}});
  for (const PatternKind pattern : kAllPatterns) {
    for (const Variant& variant : AllVariants()) EXPECT_LE(See(c, pattern, 16, variant).sum, 1e-6);
  }
}

/// Fraction of points (x, y, t) on the pattern's lines in the pixel that a triangle covers in front of
/// the near plane, by homogeneous inside tests in long double.
double PointSampled(const MovingTriangle& triangle, int samples) {
  int64_t inside = 0;
  int64_t count = 0;
  const auto determinant = [](const RasterPoint& a, const RasterPoint& b, const RasterPoint& c) {
    return (long double)a.x * (b.y * c.w - b.w * c.y) - (long double)a.y * (b.x * c.w - b.w * c.x) +
           (long double)a.w * (b.x * c.y - b.y * c.x);
  };
  for (int i = 0; i < samples; ++i) {
    const double t = (i + 0.5) / samples;
    RasterPoint v[3];
    for (size_t k = 0; k < 3; ++k) v[k] = triangle.open[k] + t * (triangle.close[k] - triangle.open[k]);
    for (int j = 0; j < samples; ++j) {
      for (const bool horizontal : {true, false}) {
        const double along = (j + 0.5) / samples;
        const RasterPoint at{horizontal ? along : 0.5, horizontal ? 0.5 : along, 0, 1};
        ++count;
        // Solve at = Σ b_i v_i by determinants; in front means that all b_i and 1/w agree in sign.
        const long double whole = determinant(v[0], v[1], v[2]);
        if (whole == 0) continue;
        const long double b0 = determinant(at, v[1], v[2]) / whole;
        const long double b1 = determinant(v[0], at, v[2]) / whole;
        const long double b2 = determinant(v[0], v[1], at) / whole;
        if (b0 < 0 || b1 < 0 || b2 < 0) continue;
        const long double w = 1 / (b0 + b1 + b2);
        const long double z = (b0 * v[0].z + b1 * v[1].z + b2 * v[2].z) * w;
        inside += w >= z;
      }
    }
  }
  return double(inside) / double(count);
}

TEST_P(Coverage, Row13VertexThatPassesTheCamera) {
  for (uint64_t seed = 1; seed <= 32; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> around(-2, 3);
    const double near = 0.05;
    MovingTriangle triangle;
    for (size_t i = 0; i < 3; ++i) {
      const double w0 = i == 0 ? 1 : 1 + 0.2 * around(random) * 0.5;
      const double w1 = i == 0 ? -1 : w0;
      const double x = around(random);
      const double y = around(random);
      triangle.open[i] = {x * std::abs(w0), y * std::abs(w0), near, w0};
      triangle.close[i] = {x + around(random), y + around(random), near, w1};
    }
    Case c;
    c.triangles = {triangle};
    const double seen = See(c, PatternKind::k1h1v, 512).sum;
    EXPECT_TRUE(std::isfinite(seen));
    // Patches: an outline may be off by 0.1 px, here along one or two lines of one pixel.
    EXPECT_NEAR(seen, PointSampled(triangle, 512), GetParam() == ResolverKind::kPaper ? 2e-2 : 6e-3);
  }
}

TEST_P(Coverage, Row19CoplanarDuplicates) {
  for (const PatternKind pattern : kSymmetric) {
    for (const Variant& variant : AllVariants()) {
      SCOPED_TRACE(variant.Name());
      Case c;
      const MovingTriangle triangle{{At(-3, -2, 0.3), At(4, -1, 0.6), At(0.5, 5, 0.5)},
                                    {At(-2, -2, 0.4), At(5, -1, 0.5), At(1.5, 5, 0.6)}};
      c.triangles = {triangle, triangle, triangle};
      const Answer answer = See(c, pattern, 16, variant);
      EXPECT_GT(answer.coverage[0], 0.5);
      EXPECT_EQ(answer.coverage[1], 0);
      EXPECT_EQ(answer.coverage[2], 0);
    }
  }
}

TEST_P(Coverage, Row20DepthsOneUlpApart) {
  // Either may win, but the same in every pixel and for every cut into rectangles.
  const double depth = 0.5;
  const double above = std::nextafter(depth, 1.0);
  FrameSceneBuilder builder(OrthographicView(64, 64));
  for (const double d : {depth, above}) {
    builder.AddRasterTriangle(
        {RasterPoint{-100, -100, d, 1}, RasterPoint{200, -100, d, 1}, RasterPoint{0, 300, d, 1}});
  }
  const auto frame = builder.Build();
  const ResolvedTile whole(*frame, {0, 0, 64, 64}, With(PatternKind::kRgls, 4));
  for (const TileRect& rect : {TileRect{0, 0, 32, 32}, TileRect{32, 16, 8, 8}}) {
    const ResolvedTile part(*frame, rect, With(PatternKind::kRgls, 4));
    for (int y = 0; y < rect.height; ++y) {
      for (int x = 0; x < rect.width; ++x) {
        for (const uint32_t id : {0u, 1u}) {
          EXPECT_EQ(part.Coverage(x, y, id), whole.Coverage(rect.x + x, rect.y + y, id));
          EXPECT_EQ(part.Coverage(x, y, id), part.Coverage(0, 0, id));
        }
      }
    }
  }
}

TEST_P(Coverage, Row22TJunctionShowsItsGap) {
  // Two triangles meet a long edge at a vertex that misses it by delta: a real gap of delta·L/2.
  const double delta = 0.01;
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
  // Within the pixel the gap is a band of y in [0, 1]: its width is delta·(1 − |y − ½| / 1.5).
  const double gap = delta * (1 - 0.25 / 1.5);
  // No vertical line of 4h4v runs through the band; the horizontal ones are half of the weight.
  EXPECT_NEAR(See(c, PatternKind::k4h4v, 1).background, gap / 2, gap / 20);
  EXPECT_NEAR(See(c, PatternKind::kRgls, 1).background, gap, gap / 10);
}

TEST_P(Coverage, Row36SmallTrianglesHideJointly) {
  // 8 × 4 quads of two triangles each cover the pixel; none covers even one line alone.
  Case c;
  for (int i = 0; i < 8; ++i) {
    for (int j = 0; j < 4; ++j) AddRectangle(c, i / 8.0, j / 4.0, (i + 1) / 8.0, (j + 1) / 4.0, 0, 0, 0.8);
  }
  const size_t front = c.triangles.size();
  AddRectangle(c, -1, -1, 2, 2, 0.5, 0, 0.2);
  for (const PatternKind pattern : kAllPatterns) {
    const Answer answer = See(c, pattern, 16);
    EXPECT_EQ(answer.coverage[front], 0);
    EXPECT_EQ(answer.coverage[front + 1], 0);
    EXPECT_EQ(answer.background, 0);
  }
}

TEST_P(Coverage, Row37HoleOfAThousandth) {
  for (uint64_t seed = 1; seed <= 32; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937_64 random(seed);
    const double x = std::uniform_real_distribution<double>(0, 0.999)(random);
    Case c;
    AddRectangle(c, -5, -5, x, 5, 0, 0, 0.8);
    AddRectangle(c, x + 1e-3, -5, 5, 5, 0, 0, 0.8);
    AddRectangle(c, -5, -5, 5, 5, 1, 1, 0.2);
    const Answer answer = See(c, PatternKind::kRgls, 8);
    EXPECT_NEAR(answer.coverage[4] + answer.coverage[5], 1e-3, 1e-6);
    EXPECT_EQ(answer.background, 0);
  }
}

TEST_P(Coverage, Row42TouchesTheTileForAnInstant) {
  // The rectangle's edge arrives at the tile's left border at t = 1, or leaves it at t = 0.
  for (const double vx : {1.0, -1.0}) {
    Case c;
    AddRectangle(c, vx > 0 ? -6 : -5, -5, vx > 0 ? -1 : 0, 5, vx, 0);
    for (const PatternKind pattern : kAllPatterns) {
      for (const int n : {1, 16, 1000}) EXPECT_EQ(See(c, pattern, n).sum, 0);
    }
  }
}

}  // namespace
}  // namespace shutterline::engine::hard_case::coverage_test
