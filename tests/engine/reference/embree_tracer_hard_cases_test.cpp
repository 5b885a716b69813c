// Cases whose answer is a closed form in space, time or both.
#include <cmath>
#include <numbers>

#include "tests/engine/reference/reference_test_util.h"

namespace shutterline::engine {
namespace {

/// A rectangle of homogeneous raster space from far left to `right`, as high as any frame.
std::vector<RasterPoint> LeftOf(double right, double w, double znear) {
  constexpr double kFar = 1000;
  return {
      {-kFar, -kFar, znear, w}, {-kFar, kFar, znear, w}, {right, kFar, znear, w}, {right, -kFar, znear, w}};
}

const std::vector<std::array<uint32_t, 3>> kQuad{{0, 1, 2}, {0, 2, 3}};

TEST(EmbreeTracerHardCases, HalfCoveredPixel) {
  for (const FrameView& view : {PerspectiveView(32, 32), OrthographicView(32, 32)}) {
    FrameSceneBuilder builder(view);
    builder.AddRectangle(-4, -4, 10.5, 40, 3);
    const auto tracer = MakeTracer(builder.Build(), 1024);
    const Image image = RenderTiles(*tracer, 32, 32);
    for (int y = 0; y < 32; ++y) {
      for (int x = 0; x < 32; ++x) {
        // The first 1024 points have one in each of 1024 strata of x.
        const double truth = x < 10 ? 1 : x > 10 ? 0 : 0.5;
        EXPECT_NEAR(image.At(x, y)[3], truth, x == 10 ? 1.01 / 1024 : 0);
      }
    }
  }
}

/// Hard case 1: ∫∫ of a rectangle [x0 + v t, x0 + v t + a] over the pixel [0, 1].
double SlidingRectangle(double x0, double a, double v) {
  const auto r = [](double z) { return z < 0 ? 0 : z <= 1 ? z * z / 2 : z - 0.5; };
  return (r(x0 + a + v) - r(x0 + a) - r(x0 + v) + r(x0)) / v;
}

TEST(EmbreeTracerHardCases, SlidingRectangleClosedForm) {
  ASSERT_NEAR(SlidingRectangle(-2.3, 0.4, 5.1), 0.0784314, 1e-6);
  struct Case {
    double x0, a, v;
  };
  for (const Case& c : {Case{-2.3, 0.4, 5.1}, Case{-3, 3.2, 4}, Case{0.2, 0.3, 0.5}, Case{2.5, 1, -4}}) {
    SCOPED_TRACE(testing::Message() << "x0 " << c.x0 << " a " << c.a << " v " << c.v);
    for (const FrameView& view : {PerspectiveView(32, 32), OrthographicView(32, 32)}) {
      FrameSceneBuilder builder(view);
      builder.AddRectangle(9 + c.x0, -4, 9 + c.x0 + c.a, 40, 3, {}, c.v, 0);
      ExpectCoverage(builder.Build(), 9, 12, SlidingRectangle(c.x0, c.a, c.v));
    }
  }
}

TEST(EmbreeTracerHardCases, FacingFlip) {
  // The width is a |1 - 2t|; the sign of 1 - 2t says which side one sees.
  const double a = 0.8;
  for (const bool double_sided : {true, false}) {
    for (const double sign : {1.0, -1.0}) {
      const double c = 8.5, h = sign * a / 2;
      FlatLook look;
      look.double_sided = double_sided;
      FrameSceneBuilder builder(PerspectiveView(16, 16));
      builder.AddQuad({{{c - h, -2, 2}, {c - h, 20, 2}, {c + h, 20, 2}, {c + h, -2, 2}}},
                      {{{c + h, -2, 2}, {c + h, 20, 2}, {c - h, 20, 2}, {c - h, -2, 2}}}, look);
      ExpectCoverage(builder.Build(), 8, 8, double_sided ? a / 2 : a / 4);
    }
  }
}

TEST(EmbreeTracerHardCases, CullingShowsFrontsOnly) {
  FlatLook look;
  look.double_sided = false;
  for (const FrameView& view : {PerspectiveView(32, 32), OrthographicView(32, 32)}) {
    FrameSceneBuilder builder(view);
    // Counter-clockwise as one looks at the picture: down, right, up.
    builder.AddTriangle({{{2, 2, 2}, {2, 40, 2}, {14, 2, 2}}}, look);
    builder.AddTriangle({{{18, 2, 2}, {30, 2, 2}, {18, 40, 2}}}, look);
    const Image image = RenderTiles(*MakeTracer(builder.Build(), 16), 32, 32);
    EXPECT_EQ(image.At(4, 4)[3], 1) << "front";
    EXPECT_EQ(image.At(20, 4)[3], 0) << "back";
  }
}

TEST(EmbreeTracerHardCases, WhatIsCulledHidesNothing) {
  FrameSceneBuilder builder(PerspectiveView(32, 32));
  builder.AddRectangle(-4, -4, 40, 40, 5, {V3f(0, 1, 0)});
  FlatLook culled{V3f(1, 0, 0), false};
  builder.AddTriangle({{{-100, -100, 2}, {200, -100, 2}, {-100, 200, 2}}}, culled);
  const Image image = RenderTiles(*MakeTracer(builder.Build(), 20), 32, 32);
  for (int i = 0; i < 32; ++i) {
    EXPECT_EQ(image.At(i, 5)[0], 0);
    EXPECT_EQ(image.At(i, 5)[1], 1);
  }
}

TEST(EmbreeTracerHardCases, ApproachingQuadEndsAtTheNearPlane) {
  // w = 1 - 2t fills the frame until it passes the near plane: (1 - n) / 2.
  for (const double near : {0.1, 0.5}) {
    const FrameView view = PerspectiveView(16, 16, 0.8, near);
    FrameSceneBuilder builder(view);
    std::vector<RasterPoint> open = LeftOf(1000, 1, near), close = LeftOf(1000, -1, near);
    builder.AddMesh(open, close, kQuad);
    ExpectCoverage(builder.Build(), 3, 12, (1 - near) / 2);
  }
}

TEST(EmbreeTracerHardCases, PerspectiveMotionIsNotLinearInThePicture) {
  // The right edge is at X(t) = s 3t / (1 + 2t): the point at x/s = 0.5 is covered from t = 1/4 on, not ½.
  // Over a pixel, x is covered from t = x / (3s - 2x) on, whose integral is -x/2 - 3s/4 ln(3s - 2x).
  const double s = 24;
  const FrameView view = PerspectiveView(32, 32);
  FrameSceneBuilder builder(view);
  builder.AddMesh(LeftOf(0, 1, view.znear), LeftOf(3 * s, 3, view.znear), kQuad);
  const auto frame = builder.Build();
  const auto uncovered = [&](double x) { return -x / 2 - 0.75 * s * std::log(3 * s - 2 * x); };
  for (const int pixel : {0, 4, 12, 20}) {
    ExpectCoverage(frame, pixel, 9, 1 - (uncovered(pixel + 1) - uncovered(pixel)));
  }
  // Both sides of the point: the mean of the two pixels is that of the point to second order.
  const double left = EstimateCoverage(frame, 11, 9).mean, right = EstimateCoverage(frame, 12, 9).mean;
  EXPECT_NEAR((left + right) / 2, 0.75, 2e-3);
}

TEST(EmbreeTracerHardCases, RecedingEdgeClosedForm) {
  // The right edge is at h / (1 + t): the pixel [0, 1] is covered h - 1 + h ln(2 / h).
  const double h = 1.5, truth = h - 1 + h * std::log(2 / h);
  ASSERT_NEAR(truth, 0.931523, 1e-6);
  const FrameView view = PerspectiveView(16, 16);
  FrameSceneBuilder builder(view);
  builder.AddMesh(LeftOf(h, 1, view.znear), LeftOf(h, 2, view.znear), kQuad);
  ExpectCoverage(builder.Build(), 0, 7, truth);
}

TEST(EmbreeTracerHardCases, RotatingEdgeClosedForm) {
  // Below an edge that turns about a corner of the pixel from flat to diagonal, y > 1 - t x in the pixel.
  // What it covers of the pixel at time t is t/2, hence ¼ over the shutter.
  FrameSceneBuilder builder(PerspectiveView(16, 16));
  builder.AddQuad({{{4, 6, 2}, {4, 14, 2}, {12, 14, 2}, {12, 6, 2}}},
                  {{{4, 6, 2}, {4, 14, 2}, {12, 14, 2}, {12, -2, 2}}});
  ExpectCoverage(builder.Build(), 4, 5, 0.25);
}

TEST(EmbreeTracerHardCases, FarColumnsAreAsExactAsNearOnes) {
  const int width = 16384;
  FrameSceneBuilder builder(PerspectiveView(width, 32));
  builder.AddRectangle(-4, -4, 16000.5, 40, 3);
  EXPECT_NEAR(RenderRect(*MakeTracer(builder.Build(), 1024), {16000, 5, 1, 1}).At(0, 0)[3], 0.5, 2.0 / 1024);
}

TEST(EmbreeTracerHardCases, PlanesOfTheViewBelongToIt) {
  for (const bool perspective : {true, false}) {
    const FrameView view =
        perspective ? PerspectiveView(8, 8, 0.8, 0.3, 7) : OrthographicView(8, 8, 1, 0.3, 7);
    const auto alpha = [&](double distance) {
      FrameSceneBuilder builder(view);
      builder.AddRectangle(-4, -4, 12, 12, distance);
      return RenderRect(*MakeTracer(builder.Build(), 16), {4, 4, 1, 1}).At(0, 0)[3];
    };
    EXPECT_EQ(alpha(0.3), 1);
    EXPECT_EQ(alpha(7), 1);
    EXPECT_EQ(alpha(0.29999), 0);
    EXPECT_EQ(alpha(7.0001), 0);
  }
  // An orthographic near plane may be at the eye.
  FrameSceneBuilder builder(OrthographicView(8, 8, 1, 0, 7));
  builder.AddRectangle(-4, -4, 12, 12, 0);
  EXPECT_EQ(RenderRect(*MakeTracer(builder.Build(), 16), {4, 4, 1, 1}).At(0, 0)[3], 1);
}

}  // namespace
}  // namespace shutterline::engine
