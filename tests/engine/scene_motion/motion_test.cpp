#include "worker/engine/scene/motion.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/engine/scene_motion/scene_builder.h"

namespace shutterline::engine::motion_test {
namespace {

RasterPoint RandomPoint(std::mt19937& random) {
  std::uniform_real_distribution<double> unit(-10, 10);
  return {unit(random), unit(random), unit(random), 15 + unit(random)};
}

TEST(InterpolateBezier, PassesThroughItsPointsAndKeepsRest) {
  for (unsigned seed = 0; seed < 100; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937 random(seed);
    for (size_t degree = 1; degree <= 3; ++degree) {
      std::vector<RasterPoint> points;
      for (size_t i = 0; i <= degree; ++i) points.push_back(RandomPoint(random));
      std::vector<RasterPoint> curve = points, reversed(points.rbegin(), points.rend());
      InterpolateBezier(curve);
      for (size_t i = 0; i <= degree; ++i) {
        const RasterPoint p = BezierPoint(curve.data(), int(degree), double(i) / double(degree));
        EXPECT_NEAR(p.x, points[i].x, 1e-12);
        EXPECT_NEAR(p.w, points[i].w, 1e-12);
      }
      EXPECT_EQ(curve.front(), points.front());
      EXPECT_EQ(curve.back(), points.back());
      InterpolateBezier(reversed);
      EXPECT_TRUE(std::equal(curve.begin(), curve.end(), reversed.rbegin())) << "reversed, bit for bit";
      std::vector<RasterPoint> rest(degree + 1, points[0]);
      InterpolateBezier(rest);
      for (const RasterPoint& p : rest) EXPECT_EQ(p, points[0]);
    }
  }
}

TEST(PathError, IsThatOfTheRasterInFrontAndOfTheAngleBehind) {
  FrameView view;
  view.width = view.height = 100;
  view.scale_x = view.scale_y = 100;
  view.center_x = view.center_y = 50;
  const RasterPoint here = view.RasterFromView(V3d(0, 0, -5));
  EXPECT_NEAR(PathErrorBetween(view, here, view.RasterFromView(V3d(0.01, 0, -5))).pixels, 0.2, 1e-12);
  EXPECT_NEAR(PathErrorBetween(view, here, view.RasterFromView(V3d(0, 0, -5.5))).depth, 1 - 5 / 5.5, 1e-12);
  const RasterPoint behind = view.RasterFromView(V3d(0, 0, 5));
  EXPECT_NEAR(PathErrorBetween(view, behind, view.RasterFromView(V3d(0.01, 0, 5))).pixels, 0.2, 1e-12);
  EXPECT_EQ(PathErrorBetween(view, behind, behind).pixels, 0);
  // Far outside of the frame, the same distance shows less.
  const RasterPoint far_out = view.RasterFromView(V3d(50, 0, -5));
  EXPECT_LT(PathErrorBetween(view, far_out, view.RasterFromView(V3d(50.01, 0, -5))).pixels, 0.03);
  const RasterPoint never{NAN, 0, 0, 1};
  EXPECT_EQ(PathErrorBetween(view, here, never).pixels, 0);
}

}  // namespace
}  // namespace shutterline::engine::motion_test
