// Hard cases whose answers are integrals over the shutter. The slice resolver samples time, so it cannot
// give them exactly: it must converge to the closed form, and the tests fit how fast.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

#include "tests/stability/hard_case.h"

namespace shutterline::engine::hard_case::motion_integrals_test {
namespace {

/// The root mean square over seeds of the error with n instants, for a ladder of n, must fall at least as
/// n^slope and end below `last`.
void ExpectConvergence(const std::function<double(uint64_t seed, int n)>& error, double slope, double last) {
  const std::vector<int> ladder{8, 16, 32, 64, 128, 256, 512};
  std::vector<double> rms;
  for (const int n : ladder) {
    double sum = 0;
    constexpr int kSeeds = 32;
    for (uint64_t seed = 1; seed <= kSeeds; ++seed) sum += std::pow(error(seed, n), 2);
    rms.push_back(std::sqrt(sum / kSeeds) + 1e-15);
  }
  EXPECT_LE(FittedSlope(ladder, rms), slope) << "errors " << testing::PrintToString(rms);
  EXPECT_LE(rms.back(), last);
}

double Uniform(uint64_t seed, double low, double high) {
  std::mt19937_64 random(seed);
  return std::uniform_real_distribution<double>(low, high)(random);
}

TEST(MotionIntegrals, Row01SlidingRectangle) {
  EXPECT_NEAR(SlidingRectangle(-2.3, 0.4, 5.1), 0.0784314, 1e-7);
  for (const Variant& variant : VariantsThatKeepLines()) {
    SCOPED_TRACE(variant.Name());
    EXPECT_NEAR(Resolve(Sliding(-2.3, 0.4, 5.1), PatternKind::kRgls, 8192, variant).sum, 0.0784314, 1e-5);
  }
  ExpectConvergence(
      [](uint64_t seed, int n) {
        const double x0 = Uniform(seed, -4, -1);
        return Resolve(Sliding(x0, 0.4, 5.1), PatternKind::kRgls, n).sum - SlidingRectangle(x0, 0.4, 5.1);
      },
      -1, 1e-3);
}

TEST(MotionIntegrals, Row02VanishingMotionIsStatic) {
  for (const Variant& variant : VariantsThatKeepLines()) {
    SCOPED_TRACE(variant.Name());
    EXPECT_EQ(Resolve(Sliding(0.3, 0.4, 1e-30), PatternKind::kRgls, 16, variant).sum,
              Resolve(Sliding(0.3, 0.4, 0), PatternKind::kRgls, 16, variant).sum);
  }
}

TEST(MotionIntegrals, Row03Bullet) {
  // Visible in the pixel for a thousandth of the shutter, a thousandth of a pixel wide.
  const double expected = SlidingRectangle(-1, 1e-3, 1000);
  EXPECT_NEAR(expected, 1e-6, 1e-9);
  for (const int n : {1024, 2048, 4096, 16384}) {
    const double seen = Resolve(Sliding(-1, 1e-3, 1000), PatternKind::kRgls, n).sum;
    EXPECT_GT(seen, 0) << n;
    EXPECT_NEAR(seen, expected, 1e-3 / n * 4) << n;
  }
}

TEST(MotionIntegrals, Row04PivotingEdge) {
  // y < t·x: the edge turns about the pixel's corner.
  Case c;
  c.triangles.push_back({{At(0, 0), At(1, 0), At(0, -1e6)}, {At(0, 0), At(1, 1), At(0, -1e6)}});
  c.triangles.push_back({{At(1, 0), At(1, -1e6), At(0, -1e6)}, {At(1, 1), At(1, -1e6), At(0, -1e6)}});
  EXPECT_NEAR(1 - 0.5 + 0.5 * std::log(0.5), 0.153426, 1e-6);
  ExpectConvergence(
      [&](uint64_t seed, int n) {
        const double height = Uniform(seed, 0.1, 0.9);
        return LineCoverage(c, height, n) - (1 - height + height * std::log(height));
      },
      -1, 1e-4);
  // The whole pixel holds ¼; four horizontal lines see the mean of the closed form at their heights, the
  // vertical ones the mean of t·x, which is ¼ of them exactly.
  double horizontal = 0;
  for (const double height : {0.125, 0.375, 0.625, 0.875}) {
    horizontal += (1 - height + height * std::log(height)) / 4;
  }
  EXPECT_NEAR(Resolve(c, PatternKind::k4h4v, 4096).sum, (horizontal + 0.25) / 2, 1e-4);
  EXPECT_NEAR(Resolve(c, PatternKind::k4h4v, 4096).sum, 0.25, 0.005);
}

TEST(MotionIntegrals, Row12ApproachToTheNearPlane) {
  // A quad that fills the screen at w = 1 − 2t, in front of the near plane while w ≥ near.
  const double near = 0.05;
  Case c;
  const auto corner = [&](double x, double y, double w) -> RasterPoint {
    return {x * 100, y * 100, near, w};
  };
  AddQuad(c, {corner(-1, -1, 1), corner(1, -1, 1), corner(1, 1, 1), corner(-1, 1, 1)},
          {corner(-1, -1, -1), corner(1, -1, -1), corner(1, 1, -1), corner(-1, 1, -1)});
  for (const Variant& variant : VariantsThatKeepLines()) {
    SCOPED_TRACE(variant.Name());
    for (const int n : {16, 256, 4096}) {
      EXPECT_NEAR(Resolve(c, PatternKind::kRgls, n, variant).sum, (1 - near) / 2, 1.0 / n) << n;
    }
  }
}

TEST(MotionIntegrals, Row14PerspectivePointInTime) {
  // The edge X/W = 3t / (1 + 2t) passes x = ½ at t = ¼; linear in the screen it would pass at ½. The
  // vertical line through x = ½ sees the quad's left part from then on.
  Case c;
  AddQuad(c,
          {RasterPoint{-50, -50, 0.1, 1}, RasterPoint{0, -50, 0.1, 1}, RasterPoint{0, 50, 0.1, 1},
           RasterPoint{-50, 50, 0.1, 1}},
          {RasterPoint{-150, -150, 0.1, 3}, RasterPoint{3, -150, 0.1, 3}, RasterPoint{3, 150, 0.1, 3},
           RasterPoint{-150, 150, 0.1, 3}});
  for (const Variant& variant : AllVariants()) {
    if (variant.swap) continue;  // The answer below is for the vertical line.
    SCOPED_TRACE(variant.Name());
    constexpr int kInstants = 4096;
    const double pixel = Resolve(c, PatternKind::k1h1v, kInstants, variant).sum;
    // The horizontal line sees min(1, X): its mean in closed form; what is left of the pixel is V's.
    const double full_from = 1.0;  // 3t / (1 + 2t) = 1
    const double horizontal = 1.5 * full_from - 0.75 * std::log(1 + 2 * full_from);
    EXPECT_NEAR(2 * pixel - horizontal, 0.75, 4.0 / kInstants);
  }
}

TEST(MotionIntegrals, Row15PerspectiveArea) {
  const double h = 1.5;
  Case c;
  AddQuad(c,
          {RasterPoint{-50, -50, 0.1, 1}, RasterPoint{h, -50, 0.1, 1}, RasterPoint{h, 50, 0.1, 1},
           RasterPoint{-50, 50, 0.1, 1}},
          {RasterPoint{-50, -50, 0.1, 2}, RasterPoint{h, -50, 0.1, 2}, RasterPoint{h, 50, 0.1, 2},
           RasterPoint{-50, 50, 0.1, 2}});
  EXPECT_NEAR(h - 1 + h * std::log(2 / h), 0.931523, 1e-6);
  for (const Variant& variant : VariantsThatKeepLines()) {
    SCOPED_TRACE(variant.Name());
    EXPECT_NEAR(Resolve(c, PatternKind::kRgls, 4096, variant).sum, h - 1 + h * std::log(2 / h), 1e-4);
  }
}

TEST(MotionIntegrals, Row16DepthBilinearInPositionAndTime) {
  // A at distance ½ all over; B at distance l·t: depth here grows towards the eye, so 1 − distance.
  Case c;
  AddRectangle(c, -1, -50, 2, 50, 0, 0, 0.5);
  const auto b = [](double x, double y, double t) { return At(x, y, 1 - x * t); };
  AddQuad(c, {b(0, -50, 0), b(1, -50, 0), b(1, 50, 0), b(0, 50, 0)},
          {b(0, -50, 1), b(1, -50, 1), b(1, 50, 1), b(0, 50, 1)});
  const auto seen_of_b = [&](PatternKind pattern, int n) {
    const Answer answer = Resolve(c, pattern, n);
    EXPECT_EQ(answer.background, 0);
    return answer.coverage[2] + answer.coverage[3];
  };
  const double expected = 0.5 + 0.5 * std::log(2);
  EXPECT_NEAR(expected, 0.846574, 1e-6);
  const std::vector<int> ladder{8, 16, 32, 64, 128, 256, 512};
  std::vector<double> errors;
  for (const int n : ladder) errors.push_back(std::abs(seen_of_b(PatternKind::kRgls, n) - expected) + 1e-15);
  // One case, not a mean over many: its slope is 1 up to the ladder's first steps.
  EXPECT_LE(FittedSlope(ladder, errors), -0.95) << testing::PrintToString(errors);
  EXPECT_LE(errors.back(), 2e-4);
}

/// The mean over `parts` linear pieces of the shutter, of a case given by its state at a time.
double InPieces(const std::function<Case(double from, double to)>& piece, int parts, int instants,
                uint32_t triangle) {
  double sum = 0;
  for (int i = 0; i < parts; ++i) {
    const Answer answer =
        Resolve(piece(double(i) / parts, double(i + 1) / parts), PatternKind::kRgls, instants);
    sum += answer.coverage[triangle] + answer.coverage[triangle + 1];
  }
  return sum / parts;
}

TEST(MotionIntegrals, Row17QuadraticMotionInPieces) {
  // A surface at distance (2t − 1)² against one at ¼: nearer for half of the shutter. One linear piece
  // sees the distance 1 at both ends and never nearer; the pieces converge to the answer.
  const auto piece = [](double from, double to) {
    Case c;
    AddRectangle(c, -1, -1, 2, 2, 0, 0, 1 - 0.25);
    const auto depth = [](double t) { return 1 - (2 * t - 1) * (2 * t - 1); };
    const auto corners = [&](double t) -> std::array<RasterPoint, 4> {
      return {At(-1, -1, depth(t)), At(2, -1, depth(t)), At(2, 2, depth(t)), At(-1, 2, depth(t))};
    };
    AddQuad(c, corners(from), corners(to));
    return c;
  };
  EXPECT_EQ(InPieces(piece, 1, 64, 2), 0) << "linear motion cannot know";
  // Pieces whose ends do not hit the crossings: the error is that of the chord, quadratic in its length.
  const std::vector<int> ladder{3, 7, 15, 31};
  std::vector<double> errors;
  for (const int n : ladder) errors.push_back(std::abs(InPieces(piece, n, 2048, 2) - 0.5) + 1e-9);
  EXPECT_LE(FittedSlope(ladder, errors), -1.5) << testing::PrintToString(errors);
  EXPECT_LE(errors.back(), 1e-3);
}

TEST(MotionIntegrals, Row18DepthsThatCrossOnTheLine) {
  Case c;
  const auto level = [](double at_0, double at_1) -> std::array<RasterPoint, 4> {
    return {At(0, -50, at_0), At(1, -50, at_1), At(1, 50, at_1), At(0, 50, at_0)};
  };
  AddQuad(c, level(0.2, 0.8), level(0.2, 0.8));
  AddQuad(c, level(0.8, 0.2), level(0.8, 0.2));
  for (const Variant& variant : VariantsThatKeepLines()) {
    SCOPED_TRACE(variant.Name());
    const Answer answer = Resolve(c, PatternKind::kRgls, 4, variant);
    EXPECT_NEAR(answer.coverage[0] + answer.coverage[1], 0.5, 1e-6);
    EXPECT_NEAR(answer.coverage[2] + answer.coverage[3], 0.5, 1e-6);
    EXPECT_EQ(answer.background, 0);
  }
}

TEST(MotionIntegrals, Row27SplitShutter) {
  // The whole shutter is the mean of its halves, up to the time resolution of both.
  ExpectConvergence(
      [](uint64_t seed, int n) {
        const double x0 = Uniform(seed, -4, -1);
        const double whole = Resolve(Sliding(x0, 0.4, 5.1), PatternKind::kRgls, n).sum;
        const double first = Resolve(Sliding(x0, 0.4, 2.55), PatternKind::kRgls, n).sum;
        const double second = Resolve(Sliding(x0 + 2.55, 0.4, 2.55), PatternKind::kRgls, n).sum;
        return whole - (first + second) / 2;
      },
      -1, 1e-3);
}

TEST(MotionIntegrals, Row30ThreeKeysInPieces) {
  // X = 1 − |2t − 1|: out and back. The region left of X covers half of the pixel on average; cut at the
  // key, each piece is linear and the answer exact up to time resolution.
  const auto piece = [](double from, double to) {
    Case c;
    AddRectangle(c, 500, 500, 501, 501, 0, 0);  // Keeps the quad's number: 2.
    const auto x = [](double t) { return 1 - std::abs(2 * t - 1); };
    const auto corners = [&](double t) -> std::array<RasterPoint, 4> {
      return {At(-5, -50), At(x(t), -50), At(x(t), 50), At(-5, 50)};
    };
    AddQuad(c, corners(from), corners(to));
    return c;
  };
  EXPECT_NEAR(InPieces(piece, 2, 256, 2), 0.5, 1e-3);
  const std::vector<int> ladder{1, 3, 5, 9, 17};  // Odd: the key lies within a piece.
  std::vector<double> errors;
  for (const int n : ladder) errors.push_back(std::abs(InPieces(piece, n, 2048, 2) - 0.5) + 1e-9);
  EXPECT_LE(FittedSlope(ladder, errors), -1.5) << testing::PrintToString(errors);
}

TEST(MotionIntegrals, Row38BackInFrontForATenth) {
  // B comes in front of A at t = 0.9.
  Case c;
  AddRectangle(c, -1, -1, 2, 2, 0, 0, 0.5);
  const auto at = [](double depth) -> std::array<RasterPoint, 4> {
    return {At(-1, -1, depth), At(2, -1, depth), At(2, 2, depth), At(-1, 2, depth)};
  };
  AddQuad(c, at(0.05), at(0.55));
  for (const Variant& variant : AllVariants()) {
    SCOPED_TRACE(variant.Name());
    for (const int n : {16, 256, 4096}) {
      const Answer answer = Resolve(c, PatternKind::k2h2v, n, variant);
      EXPECT_NEAR(answer.coverage[2] + answer.coverage[3], 0.1, 1.0 / n) << n;
    }
  }
}

}  // namespace
}  // namespace shutterline::engine::hard_case::motion_integrals_test
