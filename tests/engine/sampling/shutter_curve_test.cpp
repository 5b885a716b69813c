#include "worker/engine/sampling/shutter_curve.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace shutterline::engine {
namespace {

/// The light that a piecewise linear opening lets in until t, by the trapezium rule on a fine grid.
double LightUntil(const std::vector<ShutterPoint>& points, double t) {
  double light = 0;
  for (size_t i = 0; i + 1 < points.size(); ++i) {
    const ShutterPoint &a = points[i], &b = points[i + 1];
    if (t <= a.time) break;
    const double end = std::min(t, b.time);
    const double at_end = a.opening + (b.opening - a.opening) * (end - a.time) / (b.time - a.time);
    light += 0.5 * (a.opening + at_end) * (end - a.time);
  }
  return light;
}

TEST(ShutterCurve, OpenAllTheTimeChangesNoTime) {
  const ShutterCurve box({});
  for (const double u : {0.0, 0.25, 1 - 0x1p-53}) EXPECT_EQ(box.TimeOf(u), u);
}

TEST(ShutterCurve, TriangleHasItsClosedForm) {
  const ShutterCurve triangle({{0, 0}, {0.5, 7}, {1, 0}});
  EXPECT_EQ(triangle.TimeOf(0), 0);
  EXPECT_NEAR(triangle.TimeOf(0.125), 0.25, 1e-15);
  EXPECT_NEAR(triangle.TimeOf(0.5), 0.5, 1e-15);
  EXPECT_NEAR(triangle.TimeOf(0.875), 0.75, 1e-15);
  EXPECT_LT(triangle.TimeOf(1 - 0x1p-53), 1);
}

TEST(ShutterCurve, TimesAreWhereTheShareOfLightHasComeIn) {
  for (uint32_t seed = 1; seed <= 200; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform;
    std::vector<ShutterPoint> points{{0, uniform(random)}};
    const int count = int(random() % 6);
    for (int i = 0; i < count; ++i) {
      // Some of it shut.
      points.push_back({(i + 0.2 + 0.6 * uniform(random)) / count, random() % 3 == 0 ? 0 : uniform(random)});
    }
    points.push_back({1, 0.1 + uniform(random)});
    const ShutterCurve curve(points);
    const double all = LightUntil(points, 1);
    double last = 0;
    for (int i = 0; i < 1000; ++i) {
      const double u = (i + uniform(random)) / 1000;
      const double t = curve.TimeOf(u);
      ASSERT_GE(t, last) << "seed " << seed;
      ASSERT_LT(t, 1) << "seed " << seed;
      ASSERT_NEAR(LightUntil(points, t) / all, u, 1e-12) << "seed " << seed << ", u " << u;
      last = t;
    }
  }
}

}  // namespace
}  // namespace shutterline::engine
