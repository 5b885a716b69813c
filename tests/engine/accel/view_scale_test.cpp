#include "worker/engine/accel/view_scale.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/frame_scene_builder.h"

namespace shutterline::engine {
namespace {

double ScaleOf(double size) {
  FrameSceneBuilder builder(PerspectiveView(64, 64));
  builder.AddViewTriangle({V3d(0, 0, -size), V3d(size, 0, -size), V3d(0, size / 2, -size)},
                          {V3d(0, 0, -size), V3d(3 * size, 0, -size), V3d(0, size / 2, -size)});
  return ViewScale(*builder.Build());
}

TEST(ViewScale, BringsEverySizeToTheSameRange) {
  for (const double size : {1.0, 1e-18, 1e18, 3.7e-30, 1e37}) {
    const double scale = ScaleOf(size);
    int exponent = 0;
    EXPECT_EQ(std::frexp(scale, &exponent), 0.5) << "not a power of two";
    // Motion counts: the largest coordinate is 3 size, at shutter close.
    EXPECT_GE(3 * size / scale, std::ldexp(0.999, kViewScaleExponent));
    EXPECT_LT(3 * size / scale, std::ldexp(2.001, kViewScaleExponent));
  }
}

TEST(ViewScale, IsOneForNothing) {
  EXPECT_EQ(ViewScale(*FrameSceneBuilder(PerspectiveView(64, 64)).Build()), 1);
}

TEST(ViewScale, IgnoresVerticesOfNoTriangle) {
  FrameSceneBuilder builder(PerspectiveView(64, 64));
  const std::vector<V3d> vertices{{0, 0, -1}, {1, 0, -1}, {0, 1, -1}, {1e30, 0, -1}};
  builder.AddViewMesh(vertices, {}, {{0, 1, 2}});
  EXPECT_EQ(ViewScale(*builder.Build()), std::ldexp(1.0, -kViewScaleExponent));
}

}  // namespace
}  // namespace shutterline::engine
