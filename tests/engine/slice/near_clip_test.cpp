#include "worker/engine/slice/near_clip.h"

#include <gtest/gtest.h>

#include <random>
#include <string>

namespace shutterline::engine::near_clip_test {
namespace {

bool IsInside(const LineCorner& c, double far_depth, double slack) {
  return c[3] - c[2] >= -slack && c[2] - far_depth * c[3] >= -slack;
}

TEST(NearClip, WhatIsInsideStaysAsItIs) {
  const std::array<LineCorner, 3> triangle{{{0, 0, 0.1, 1}, {1, 0, 0.1, 2}, {0, 1, 0.1, 3}}};
  const ClippedPolygon polygon = ClipTriangle(triangle, 0);
  ASSERT_EQ(polygon.count, 3);
  for (size_t i = 0; i < 3; ++i) EXPECT_EQ(polygon.corners[i], triangle[i]);
}

TEST(NearClip, WhatIsOutsideIsGone) {
  EXPECT_LT(ClipTriangle({{{0, 0, 0.1, 0.05}, {1, 0, 0.1, 0}, {0, 1, 0.1, -3}}}, 0).count, 3);
  EXPECT_LT(ClipTriangle({{{0, 0, 0.1, 20}, {1, 0, 0.1, 30}, {0, 1, 0.1, 40}}}, 0.01).count, 3);
}

TEST(NearClip, CornersAreInsideAndNeighboursShareThem) {
  for (uint64_t seed = 1; seed <= 200; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> unit(-1, 1);
    const auto corner = [&] { return LineCorner{unit(random) * 9, unit(random) * 9, 0.1, unit(random)}; };
    const LineCorner a = corner();
    const LineCorner b = corner();
    const ClippedPolygon left = ClipTriangle({a, b, corner()}, 0.15);
    const ClippedPolygon right = ClipTriangle({b, a, corner()}, 0.15);
    for (int i = 0; i < left.count; ++i) EXPECT_TRUE(IsInside(left.corners[size_t(i)], 0.15, 1e-12));
    // Where the shared edge is cut, both have the very same new corner.
    const bool cut = (a[3] >= a[2]) != (b[3] >= b[2]);
    if (!cut || left.count < 3 || right.count < 3) continue;
    int shared = 0;
    for (int i = 0; i < left.count; ++i) {
      for (int k = 0; k < right.count; ++k) {
        const LineCorner& corner_i = left.corners[size_t(i)];
        if (corner_i != right.corners[size_t(k)]) continue;
        if (corner_i != a && corner_i != b) ++shared;
      }
    }
    EXPECT_GE(shared, 1);
  }
}

}  // namespace
}  // namespace shutterline::engine::near_clip_test
