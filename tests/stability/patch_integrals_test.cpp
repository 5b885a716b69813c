// Hard cases whose answers are integrals over the shutter, for the patch engine. What moves straight on the
// screen it integrates exactly; what perspective or rotation bends, within the tolerance of its outlines.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/stability/hard_case.h"

namespace shutterline::engine::hard_case::patch_integrals_test {
namespace {

/// Ends are rounded to 2^-24 px.
constexpr double kExact = 5e-7;
/// A side of an outline may be off by twice 0.1 px in the middle of a chord, and by less on average.
constexpr double kOutline = 0.1;

Answer See(const Case& c, PatternKind pattern, int time_cells, const Variant& variant = {}) {
  RenderSettings settings = SettingsOf(ResolverKind::kPaper, pattern, 1);
  settings.time_cells = time_cells;
  return Resolve(c, settings, variant);
}

TEST(PatchIntegrals, Row01SlidingRectangle) {
  for (uint64_t seed = 1; seed <= 32; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> unit(0, 1);
    const double x0 = -4 + 3 * unit(random), a = unit(random), v = 1 + 5 * unit(random);
    for (const Variant& variant : VariantsThatKeepLines()) {
      EXPECT_NEAR(See(Sliding(x0, a, v), PatternKind::kRgls, 1 + int(seed % 7), variant).sum,
                  SlidingRectangle(x0, a, v), kExact);
    }
  }
}

TEST(PatchIntegrals, Row02VanishingMotionIsStatic) {
  EXPECT_NEAR(See(Sliding(0.3, 0.4, 1e-30), PatternKind::kRgls, 4).sum,
              See(Sliding(0.3, 0.4, 0), PatternKind::kRgls, 4).sum, kExact);
}

TEST(PatchIntegrals, Row03Bullet) {
  for (const int n : {1, 4, 16}) {
    EXPECT_NEAR(See(Sliding(-1, 1e-3, 1000), PatternKind::kRgls, n).sum, SlidingRectangle(-1, 1e-3, 1000),
                1e-9);
  }
}

TEST(PatchIntegrals, Row04PivotingEdge) {
  Case c;
  c.triangles.push_back({{At(0, 0), At(1, 0), At(0, -1e6)}, {At(0, 0), At(1, 1), At(0, -1e6)}});
  c.triangles.push_back({{At(1, 0), At(1, -1e6), At(0, -1e6)}, {At(1, 1), At(1, -1e6), At(0, -1e6)}});
  double horizontal = 0;
  for (const double height : {0.125, 0.375, 0.625, 0.875})
    horizontal += (1 - height + height * std::log(height)) / 4;
  EXPECT_NEAR(See(c, PatternKind::k4h4v, 4).sum, (horizontal + 0.25) / 2, kOutline / 2);
}

TEST(PatchIntegrals, Row10FacingFlip) {
  for (const double a : {0.2, 0.7, 1.0}) {
    Case c;
    const auto corners = [&](double w) -> std::array<RasterPoint, 4> {
      return {At(0.5 - w / 2, -50), At(0.5 - w / 2, 50), At(0.5 + w / 2, 50), At(0.5 + w / 2, -50)};
    };
    AddQuad(c, corners(a), corners(-a));
    for (const Variant& variant : VariantsThatKeepLines()) {
      SCOPED_TRACE(variant.Name());
      c.double_sided = true;
      EXPECT_NEAR(See(c, PatternKind::kRgls, 3, variant).sum, a / 2, kExact);
      c.double_sided = false;
      EXPECT_NEAR(See(c, PatternKind::kRgls, 3, variant).sum, a / 4, kExact);
    }
  }
}

TEST(PatchIntegrals, Row12ApproachToTheNearPlane) {
  const double near = 0.05;
  Case c;
  const auto corner = [&](double x, double y, double w) -> RasterPoint {
    return {x * 100, y * 100, near, w};
  };
  AddQuad(c, {corner(-1, -1, 1), corner(1, -1, 1), corner(1, 1, 1), corner(-1, 1, 1)},
          {corner(-1, -1, -1), corner(1, -1, -1), corner(1, 1, -1), corner(-1, 1, -1)});
  for (const Variant& variant : VariantsThatKeepLines()) {
    SCOPED_TRACE(variant.Name());
    for (const int n : {1, 4, 7})
      EXPECT_NEAR(See(c, PatternKind::kRgls, n, variant).sum, (1 - near) / 2, kExact);
  }
}

TEST(PatchIntegrals, Row15PerspectiveArea) {
  const double h = 1.5;
  Case c;
  AddQuad(c,
          {RasterPoint{-50, -50, 0.1, 1}, RasterPoint{h, -50, 0.1, 1}, RasterPoint{h, 50, 0.1, 1},
           RasterPoint{-50, 50, 0.1, 1}},
          {RasterPoint{-50, -50, 0.1, 2}, RasterPoint{h, -50, 0.1, 2}, RasterPoint{h, 50, 0.1, 2},
           RasterPoint{-50, 50, 0.1, 2}});
  for (const Variant& variant : VariantsThatKeepLines()) {
    SCOPED_TRACE(variant.Name());
    EXPECT_NEAR(See(c, PatternKind::kRgls, 4, variant).sum, h - 1 + h * std::log(2 / h), kOutline / 2);
  }
}

TEST(PatchIntegrals, Row16DepthBilinearInPositionAndTime) {
  // No plane follows l·t: two patch triangles over the whole cell would give 0.75 or 0.875. Planes are fitted
  // in parts of a cell, so the answer comes as close as these are small.
  Case c;
  AddRectangle(c, -1, -50, 2, 50, 0, 0, 0.5);
  const auto b = [](double x, double y, double t) { return At(x, y, 1 - x * t); };
  AddQuad(c, {b(0, -50, 0), b(1, -50, 0), b(1, 50, 0), b(0, 50, 0)},
          {b(0, -50, 1), b(1, -50, 1), b(1, 50, 1), b(0, 50, 1)});
  for (const int n : {1, 2, 4, 16}) {
    const Answer answer = See(c, PatternKind::kRgls, n);
    EXPECT_EQ(answer.background, 0);
    EXPECT_NEAR(answer.coverage[2] + answer.coverage[3], 0.5 + 0.5 * std::log(2), 0.01 / n) << n;
  }
}

TEST(PatchIntegrals, Row18DepthsThatCrossOnTheLine) {
  Case c;
  const auto level = [](double at_0, double at_1, double dx) -> std::array<RasterPoint, 4> {
    return {At(dx, -50, at_0), At(1 + dx, -50, at_1), At(1 + dx, 50, at_1), At(dx, 50, at_0)};
  };
  // At rest, and so that both move: they cross at l = ½ + t.
  AddQuad(c, level(0.2, 0.8, 0), level(0.2, 0.8, 0));
  AddQuad(c, level(0.8, 0.2, 0), level(0.8, 0.2, 0));
  const Answer still = See(c, PatternKind::kRgls, 4);
  EXPECT_NEAR(still.coverage[0] + still.coverage[1], 0.5, kExact);
  Case moving;
  AddQuad(moving, level(0.2, 0.8, 0), level(0.2, 0.8, 1));
  AddQuad(moving, level(0.8, 0.2, 0), level(0.8, 0.2, 1));
  for (const int n : {1, 4}) {
    const Answer answer = See(moving, PatternKind::kRgls, n);
    // Of the pixel they cover [t, 1]: from t to ½ + t (cut at 1) the second is nearer.
    EXPECT_NEAR(answer.coverage[2] + answer.coverage[3], 0.375, kExact);
    EXPECT_NEAR(answer.coverage[0] + answer.coverage[1], 0.125, kExact);
  }
}

TEST(PatchIntegrals, Row27SplitShutter) {
  for (uint64_t seed = 1; seed <= 32; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937_64 random(seed);
    const double x0 = std::uniform_real_distribution<double>(-4, -1)(random);
    const double whole = See(Sliding(x0, 0.4, 5.1), PatternKind::kRgls, 4).sum;
    const double first = See(Sliding(x0, 0.4, 2.55), PatternKind::kRgls, 4).sum;
    const double second = See(Sliding(x0 + 2.55, 0.4, 2.55), PatternKind::kRgls, 4).sum;
    EXPECT_NEAR(whole, (first + second) / 2, kExact);
  }
}

TEST(PatchIntegrals, Row38BackInFrontForATenth) {
  Case c;
  AddRectangle(c, -1, -1, 2, 2, 0, 0, 0.5);
  const auto at = [](double depth) -> std::array<RasterPoint, 4> {
    return {At(-1, -1, depth), At(2, -1, depth), At(2, 2, depth), At(-1, 2, depth)};
  };
  AddQuad(c, at(0.05), at(0.55));
  for (const Variant& variant : AllVariants()) {
    SCOPED_TRACE(variant.Name());
    for (const int n : {1, 4, 16}) {
      const Answer answer = See(c, PatternKind::k2h2v, n, variant);
      EXPECT_NEAR(answer.coverage[2] + answer.coverage[3], 0.1, kExact) << n;
      EXPECT_EQ(answer.background, 0);
    }
  }
}

}  // namespace
}  // namespace shutterline::engine::hard_case::patch_integrals_test
