#include "worker/engine/accel/facing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "common/math/bezier.h"
#include "tests/support/frame_scene_builder.h"
#include "worker/engine/accel/bvh.h"

namespace shutterline::engine {
namespace {

double Determinant(const RasterPoint& a, const RasterPoint& b, const RasterPoint& c) {
  return a.x * (b.y * c.w - b.w * c.y) - a.y * (b.x * c.w - b.w * c.x) + a.w * (b.x * c.y - b.y * c.x);
}

TEST(Facing, AlwaysBackIsBackAtEveryInstantAndIsFound) {
  int always = 0, found = 0;
  for (unsigned seed = 0; seed < 4000; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(-1, 1);
    const int degree = int(seed % 4), pieces = degree == 0 ? 1 : 1 << seed % 3;
    const size_t count = size_t(degree * pieces + 1);
    const double speed = 0.3 * (1 + unit(random));
    std::vector<RasterPoint> points;
    for (size_t k = 0; k < 3; ++k) {
      const RasterPoint at{100 * unit(random), 100 * unit(random), 0.1, 1.5 + 2 * unit(random)};
      for (size_t i = 0; i < count; ++i) {
        points.push_back({at.x + speed * 100 * unit(random), at.y + speed * 100 * unit(random), 0.1,
                          at.w + speed * unit(random)});
      }
    }
    const bool back = ShowsItsBackAlways({&points[0], &points[count], &points[2 * count]}, degree, pieces);
    bool sampled = true;
    for (int i = 0; i <= 200; ++i) {
      const CurvePosition at = CurvePositionAt(pieces, i / 200.0);
      std::array<RasterPoint, 3> p;
      for (size_t k = 0; k < 3; ++k) {
        p[k] = BezierPoint(&points[k * count + size_t(at.piece * degree)], degree, at.u);
      }
      const double determinant = Determinant(p[0], p[1], p[2]);
      if (back) {
        ASSERT_GT(determinant, 0) << "at " << i / 200.0;
      }
      sampled = sampled && determinant > 0;
    }
    always += sampled;
    found += back;
  }
  EXPECT_GT(always, 1000);
  EXPECT_GT(found, 0.85 * always);
}

TEST(Facing, TheHierarchyLeavesOutWhatAlwaysShowsItsBack) {
  FrameSceneBuilder builder(PerspectiveView(96, 96));
  const FlatLook single{.double_sided = false};
  const std::array<Corner, 3> front{{{10, 40, 2}, {50, 40, 2}, {50, 20, 2}}};
  const std::array<Corner, 3> back{{{10, 40, 2}, {50, 20, 2}, {50, 40, 2}}};
  builder.AddTriangle(front, single);
  builder.AddTriangle(back, single);
  builder.AddTriangle(back, {.double_sided = true});
  builder.AddTriangle(back, front, single);  // Turns.
  builder.AddTriangle(back, {{{12, 40, 2}, {52, 20, 2}, {52, 40, 2}}}, single);
  const auto bvh = Bvh::Build(builder.Build(), 1);
  ASSERT_TRUE(bvh.ok());
  std::vector<uint32_t> triangles;
  (*bvh)->CollectVisible({0, 0, 96, 96}, triangles);
  std::sort(triangles.begin(), triangles.end());
  EXPECT_EQ(triangles, (std::vector<uint32_t>{0, 2, 3}));
}

}  // namespace
}  // namespace shutterline::engine
