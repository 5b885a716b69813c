#include "worker/engine/accel/time_bounds.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "common/math/bezier.h"

namespace shutterline::engine {
namespace {

/// Whether all corners are outside of one plane.
bool IsOutside(const std::array<RasterPoint, 3>& p, const RasterBox& box) {
  const auto all = [&](auto outside) { return std::all_of(p.begin(), p.end(), outside); };
  return all([&](const RasterPoint& q) { return q.x < box.x0 * q.w; }) ||
         all([&](const RasterPoint& q) { return q.x > box.x1 * q.w; }) ||
         all([&](const RasterPoint& q) { return q.y < box.y0 * q.w; }) ||
         all([&](const RasterPoint& q) { return q.y > box.y1 * q.w; }) ||
         all([&](const RasterPoint& q) { return q.w < q.z; }) ||
         all([&](const RasterPoint& q) { return q.z < box.far_depth * q.w; });
}

TEST(TimesInside, HoldsEveryInstantInsideAndLittleElse) {
  double inside = 0, bounded = 0, loosest = 0;
  int cases = 0;
  for (unsigned seed = 0; seed < 3000; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(-1, 1);
    const int degree = 1 + int(seed % 3), pieces = 1 << (seed / 3) % 4;
    const int count = degree * pieces + 1;
    const RasterBox box{32, 64, 32, 64, seed % 2 ? 0.02 : 0.0};
    std::vector<RasterPoint> points;
    const double x = 48 + 60 * unit(random), y = 48 + 60 * unit(random);
    for (int k = 0; k < 3; ++k) {
      for (int i = 0; i < count; ++i) {
        const double w = seed % 5 == 0 ? 2 * unit(random) : 2 + unit(random);
        points.push_back({(x + 60 * unit(random)) * w, (y + 60 * unit(random)) * w, 0.1, w});
      }
    }
    const TimeInterval times =
        TimesInside({&points[0], &points[size_t(count)], &points[2 * size_t(count)]}, degree, pieces, box);
    constexpr int kInstants = 400;
    int first = kInstants + 1, last = -1;
    for (int i = 0; i <= kInstants; ++i) {
      const double t = double(i) / kInstants;
      const CurvePosition at = CurvePositionAt(pieces, t);
      std::array<RasterPoint, 3> p;
      for (size_t k = 0; k < 3; ++k) {
        p[k] = BezierPoint(&points[k * size_t(count) + size_t(at.piece * degree)], degree, at.u);
      }
      if (IsOutside(p, box)) continue;
      ASSERT_LE(times.in, t);
      ASSERT_GE(times.out, t);
      first = std::min(first, i);
      last = i;
    }
    if (times.IsEmpty()) continue;
    ++cases;
    const double seen = std::max(0, last - first) / double(kInstants);
    inside += seen;
    bounded += times.out - times.in;
    loosest = std::max(loosest, times.out - times.in - seen);
  }
  EXPECT_GT(cases, 1000);
  EXPECT_LT(bounded, 1.15 * inside) << "bounds that hold everything would be useless; loosest " << loosest;
}

TEST(TimesInside, StraightMotionIsSolved) {
  // A point-like triangle slides from x = 0 to 100: inside 32 to 64 from t = 0.32 to 0.64.
  std::vector<RasterPoint> points;
  for (int k = 0; k < 3; ++k) {
    points.push_back({0, 48, 0.1, 1});
    points.push_back({100, 48, 0.1, 1});
  }
  const RasterBox box{32, 64, 32, 64, 0};
  const TimeInterval times = TimesInside({&points[0], &points[2], &points[4]}, 1, 1, box);
  EXPECT_NEAR(times.in, 0.32, 1e-8);
  EXPECT_NEAR(times.out, 0.64, 1e-8);
  EXPECT_TRUE(TimesInside({&points[0], &points[2], &points[4]}, 0, 1, box).IsEmpty());
}

}  // namespace
}  // namespace shutterline::engine
