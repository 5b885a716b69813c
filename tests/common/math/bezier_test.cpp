#include "common/math/bezier.h"

#include <gtest/gtest.h>

#include <array>
#include <random>

namespace shutterline {
namespace {

class RandomCurve {
 public:
  explicit RandomCurve(unsigned seed) : random_(seed) {}

  RasterPoint Point() { return {Number(), Number(), Number(), Number()}; }
  double Number() { return std::uniform_real_distribution<double>(-100, 100)(random_); }
  double Unit() { return std::uniform_real_distribution<double>(0, 1)(random_); }

 private:
  std::mt19937 random_;
};

void ExpectNear(const RasterPoint& a, const RasterPoint& b, double tolerance) {
  EXPECT_NEAR(a.x, b.x, tolerance);
  EXPECT_NEAR(a.y, b.y, tolerance);
  EXPECT_NEAR(a.z, b.z, tolerance);
  EXPECT_NEAR(a.w, b.w, tolerance);
}

TEST(Bezier, EndsAreExactAndRestIsRest) {
  for (unsigned seed = 0; seed < 200; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    RandomCurve random(seed);
    for (int degree = 1; degree <= kMaxBezierDegree; ++degree) {
      std::array<RasterPoint, 4> c{random.Point(), random.Point(), random.Point(), random.Point()};
      EXPECT_EQ(BezierPoint(c.data(), degree, 0), c[0]);
      EXPECT_EQ(BezierPoint(c.data(), degree, 1), c[size_t(degree)]);
      c.fill(c[0]);
      std::array<RasterPoint, 4> power;
      BezierToPower(c.data(), degree, power.data());
      const double u = random.Unit();
      EXPECT_EQ(PowerPoint(power.data(), degree, u), c[0]);
      if (degree > 1) {
        EXPECT_EQ(BezierPoint(c.data(), degree, u), c[0]);
      }
    }
  }
}

TEST(Bezier, AgreesWithDeCasteljauAndWithItsPowerForm) {
  for (unsigned seed = 0; seed < 200; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    RandomCurve random(seed);
    for (int degree = 1; degree <= kMaxBezierDegree; ++degree) {
      const std::array<RasterPoint, 4> c{random.Point(), random.Point(), random.Point(), random.Point()};
      const double u = random.Unit();
      std::array<RasterPoint, 4> q = c;
      for (int level = degree; level > 0; --level) {
        for (int i = 0; i < level; ++i) q[size_t(i)] = (1 - u) * q[size_t(i)] + u * q[size_t(i) + 1];
      }
      ExpectNear(BezierPoint(c.data(), degree, u), q[0], 1e-12);
      std::array<RasterPoint, 4> power;
      BezierToPower(c.data(), degree, power.data());
      ExpectNear(PowerPoint(power.data(), degree, u), q[0], 1e-11);
    }
  }
}

TEST(Bezier, ReversedInTimeIsBitIdentical) {
  for (unsigned seed = 0; seed < 200; ++seed) {
    RandomCurve random(seed);
    for (int degree = 1; degree <= kMaxBezierDegree; ++degree) {
      std::array<RasterPoint, 4> c{random.Point(), random.Point(), random.Point(), random.Point()};
      const double u = std::ldexp(std::floor(random.Unit() * 1024), -10);  // 1 - u is exact.
      const RasterPoint forth = BezierPoint(c.data(), degree, u);
      std::reverse(c.begin(), c.begin() + degree + 1);
      EXPECT_EQ(BezierPoint(c.data(), degree, 1 - u), forth) << "seed " << seed << ", degree " << degree;
    }
  }
}

TEST(Bezier, PositionsOfTimes) {
  for (const int pieces : {1, 2, 8, 64}) {
    EXPECT_EQ(CurvePositionAt(pieces, 0).piece, 0);
    EXPECT_EQ(CurvePositionAt(pieces, 0).u, 0);
    EXPECT_EQ(CurvePositionAt(pieces, 1).piece, pieces - 1);
    EXPECT_EQ(CurvePositionAt(pieces, 1).u, 1);
    for (int i = 1; i < pieces; ++i) {
      EXPECT_EQ(CurvePositionAt(pieces, double(i) / pieces).piece, i);
      EXPECT_EQ(CurvePositionAt(pieces, double(i) / pieces).u, 0);
      const CurvePosition before = CurvePositionAt(pieces, std::nextafter(double(i) / pieces, 0));
      EXPECT_EQ(before.piece, i - 1);
      EXPECT_LT(before.u, 1);
    }
  }
}

}  // namespace
}  // namespace shutterline
