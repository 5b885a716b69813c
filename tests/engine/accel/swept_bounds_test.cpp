#include "worker/engine/accel/swept_bounds.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "common/math/bezier.h"

namespace shutterline::engine {
namespace {

constexpr double kNear = 0.1;

/// Control points of three corners, one after the other, of a perspective camera whose near plane is at
/// kNear.
struct RandomSweep {
  int degree, count;
  std::vector<RasterPoint> points;

  /// `nearest`: the least w, which may be behind the eye. `reach`: how far out places are, pixels.
  RandomSweep(std::mt19937& random, double nearest, double reach)
      : degree(int(random() % 4)), count(degree + 1) {
    std::uniform_real_distribution<double> unit(0, 1);
    for (int i = 0; i < 3 * count; ++i) {
      const double w = nearest + 3 * unit(random);
      points.push_back({reach * (2 * unit(random) - 1) * std::abs(w),
                        reach * (2 * unit(random) - 1) * std::abs(w), kNear, w});
    }
  }
  RasterPoint At(double t, double b1, double b2) const {
    RasterPoint p;
    const double b[3] = {1 - b1 - b2, b1, b2};
    for (int k = 0; k < 3; ++k) p = p + b[k] * BezierPoint(&points[size_t(k * count)], degree, t);
    return p;
  }
};

bool Holds(const SweptBounds& b, double x, double y) {
  return x >= double(b.x0) && x <= double(b.x1) && y >= double(b.y0) && y <= double(b.y1);
}

TEST(SweptBounds, HoldWhateverIsVisible) {
  int visible = 0, hidden = 0, empty = 0;
  for (unsigned seed = 0; seed < 3000; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(0, 1);
    const double nearest = std::array{-3.2, -2.0, -0.5, 0.05, 0.2}[seed % 5];
    const double reach = seed % 7 == 0 ? 0x1p24 : 300;
    const double far_depth = seed % 2 == 0 ? 0 : kNear / 2;
    const RandomSweep sweep(random, nearest, reach);
    const SweptBounds bounds = BoundsInRaster(sweep.points, far_depth);
    ASSERT_FALSE(std::isnan(bounds.x0 + bounds.x1 + bounds.y0 + bounds.y1) && !bounds.IsEmpty());
    empty += bounds.IsEmpty();
    for (int i = 0; i < 60; ++i) {
      const double b1 = unit(random), b2 = (1 - b1) * unit(random);
      const RasterPoint p = sweep.At(unit(random), b1, b2);
      if (p.w < p.z || p.z < far_depth * p.w) {
        ++hidden;
        continue;
      }
      ++visible;
      ASSERT_TRUE(Holds(bounds, p.x / p.w, p.y / p.w))
          << p.x / p.w << ", " << p.y / p.w << " in " << bounds.x0 << " " << bounds.x1 << " " << bounds.y0
          << " " << bounds.y1;
    }
  }
  EXPECT_GT(visible, 30000);
  EXPECT_GT(hidden, 30000);
  EXPECT_GT(empty, 100);
}

TEST(SweptBounds, AreThoseOfTheControlPointsInFront) {
  for (unsigned seed = 0; seed < 500; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937 random(seed);
    const RandomSweep sweep(random, 0.2, 300);
    double x0 = INFINITY, x1 = -INFINITY, y0 = INFINITY, y1 = -INFINITY;
    for (const RasterPoint& p : sweep.points) {
      x0 = std::min(x0, p.x / p.w);
      x1 = std::max(x1, p.x / p.w);
      y0 = std::min(y0, p.y / p.w);
      y1 = std::max(y1, p.y / p.w);
    }
    const SweptBounds bounds = BoundsInRaster(sweep.points, 0);
    EXPECT_NEAR(double(bounds.x0), x0, 1e-4);
    EXPECT_NEAR(double(bounds.x1), x1, 1e-4);
    EXPECT_NEAR(double(bounds.y0), y0, 1e-4);
    EXPECT_NEAR(double(bounds.y1), y1, 1e-4);
  }
}

TEST(SweptBounds, EndAtTheNearPlane) {
  // From (10, 10) a metre away to behind the eye, straight along the axis through (10, 10): seen there only.
  const std::vector<RasterPoint> along{{10, 10, kNear, 1}, {-10, -10, kNear, -1}};
  const SweptBounds point = BoundsInRaster(along, 0);
  EXPECT_NEAR(double(point.x0), 10, 1e-4);
  EXPECT_NEAR(double(point.x1), 10, 1e-4);
  // And one that leaves sideways, by 9 pixel metres a metre: at the near plane, 0.9 of the way, it is at 91.
  const std::vector<RasterPoint> aside{{10, 10, kNear, 1}, {9.1, 1, kNear, 0.1}};
  EXPECT_NEAR(double(BoundsInRaster(aside, 0).x1), 91, 1e-3);
  const std::vector<RasterPoint> beyond{{10, 10, kNear, 1}, {9, 0, kNear, 0}};
  EXPECT_NEAR(double(BoundsInRaster(beyond, 0).x1), 91, 1e-3);
}

TEST(SweptBounds, OfWhatIsNeverVisibleAreEmpty) {
  const std::vector<RasterPoint> behind{{1, 1, kNear, 0.05}, {2, 2, kNear, -1}};
  EXPECT_TRUE(BoundsInRaster(behind, 0).IsEmpty());
  const std::vector<RasterPoint> far{{1, 1, kNear, 11}, {2, 2, kNear, 12}};
  EXPECT_TRUE(BoundsInRaster(far, kNear / 10).IsEmpty());
  EXPECT_FALSE(BoundsInRaster(far, 0).IsEmpty());
  const TileBorders all({0, 0, 1 << 20, 1 << 20});
  EXPECT_FALSE(all.Overlap({}));
  EXPECT_TRUE(all.Hold({}));
}

TEST(TileBorders, OverlapAndHold) {
  const TileBorders tile({32, 64, 32, 16});  // To 64, 80.
  EXPECT_TRUE(tile.Overlap({0, 0, 32, 64})) << "touches a corner";
  EXPECT_FALSE(tile.Overlap({0, 0, 31.99f, 70}));
  EXPECT_FALSE(tile.Overlap({64.01f, 70, 70, 71}));
  EXPECT_FALSE(tile.Overlap({40, 80.01f, 41, 90}));
  EXPECT_TRUE(tile.Overlap({0, 0, 100, 100}));
  EXPECT_FALSE(tile.Hold({0, 0, 100, 100}));
  EXPECT_TRUE(tile.Hold({32, 64, 64, 80}));
  EXPECT_FALSE(tile.Hold({32, 64, 64.01f, 80}));
}

}  // namespace
}  // namespace shutterline::engine
