#include "worker/engine/slice/upper_slefe.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace shutterline::engine::upper_slefe_test {
namespace {

constexpr size_t kCurves = 8;
using Curves = std::array<std::array<double, kCurves>, kMaxBezierDegree + 1>;

double At(const Curves& c, int degree, size_t n, double u) {
  RasterPoint points[kMaxBezierDegree + 1];
  for (int i = 0; i <= degree; ++i) points[i].x = c[size_t(i)][n];
  return BezierPoint(points, degree, u).x;
}

TEST(UpperSlefe, LiesAboveTheCurveAndBelowTheHullOfItsControlPolygon) {
  std::array<double, 4> slefe_gap{}, hull_gap{};
  for (unsigned seed = 0; seed < 600; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(-1, 1);
    const int degree = 1 + int(seed % 3);
    // Far from zero the bound must take its rounding into account.
    const double offset = seed % 5 == 0 ? 0x1p30 * unit(random) : 0;
    Curves c{};
    for (int i = 0; i <= degree; ++i) {
      for (double& value : c[size_t(i)]) value = offset + unit(random);
    }
    std::array<std::array<double, kCurves>, kSlefeSegments + 1> upper;
    UpperSlefe(c, degree, upper);
    for (size_t n = 0; n < kCurves; ++n) {
      for (int i = 0; i <= 256; ++i) {
        const double u = i / 256.0;
        const double value = At(c, degree, n, u);
        const size_t j = std::min(kSlefeSegments - 1, size_t(u * kSlefeSegments));
        const double share = u * kSlefeSegments - double(j);
        const double bound = (1 - share) * upper[j][n] + share * upper[j + 1][n];
        ASSERT_GE(bound, value) << "degree " << degree << " at " << u;
        // The upper hull of the control points, at u.
        double hull = -INFINITY;
        for (int a = 0; a <= degree; ++a) {
          for (int b = a; b <= degree; ++b) {
            const double ua = double(a) / degree, ub = double(b) / degree;
            if (u < ua || u > ub) continue;
            const double s = ua == ub ? 0 : (u - ua) / (ub - ua);
            hull = std::max(hull, (1 - s) * c[size_t(a)][n] + s * c[size_t(b)][n]);
          }
        }
        if (offset != 0) continue;
        slefe_gap[size_t(degree)] += bound - value;
        hull_gap[size_t(degree)] += hull - value;
      }
    }
  }
  EXPECT_LT(slefe_gap[1], 1e-6 * double(kCurves) * 200 * 257) << "straight motion is bounded by itself";
  for (const size_t degree : {2, 3}) {
    EXPECT_LT(slefe_gap[degree], 0.35 * hull_gap[degree]) << "degree " << degree;
  }
}

}  // namespace
}  // namespace shutterline::engine::upper_slefe_test
