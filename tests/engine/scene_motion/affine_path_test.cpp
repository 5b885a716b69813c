#include "worker/engine/scene/affine_path.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

#include "common/math/bezier.h"
#include "worker/engine/scene/mesh_pose.h"
#include "worker/engine/scene/motion.h"

namespace shutterline::engine::affine_path_test {
namespace {

FrameView View(bool perspective) {
  FrameView view;
  view.perspective = perspective;
  view.width = 400;
  view.height = 300;
  view.scale_x = view.scale_y = perspective ? 300 : 40;
  view.center_x = 200;
  view.center_y = 150;
  view.znear = 0.1;
  view.zfar = perspective ? 0 : 50;
  return view;
}

/// A body that turns and flies before the camera, at shutter time t.
M44d PoseAt(double t, double turn, const V3d& way, double distance) {
  M44d m;
  m.rotate(V3d(0.3, turn * t, 0.5 * turn * t));
  M44d shift;
  shift.translate(V3d(0, 0, -distance) + t * way);
  return m * shift;
}

TEST(AffinePath, SaysYesOnlyWhereEveryVertexIsWithinTolerance) {
  std::mt19937 random(20);  // The seed of everything below.
  std::uniform_real_distribution<double> unit(0, 1);
  int yes = 0, could_be_yes = 0;
  for (int round = 0; round < 3000; ++round) {
    const FrameView view = View(round % 4 != 0);
    const int degree = 1 + round % 3;
    const double turn = std::pow(10.0, 2.5 * unit(random) - 2.5);
    const double distance = 1 + 20 * unit(random);
    const V3d way = std::pow(10.0, 2 * unit(random) - 2) *
                    V3d(unit(random) - 0.5, unit(random) - 0.5, unit(random) - 0.5);
    const V3d low(-unit(random), -unit(random), -unit(random)),
        high(unit(random), unit(random), unit(random));
    const Box3d box(low, high);
    const double u = unit(random);
    std::array<M44d, 4> poses;
    std::array<const M44d*, 4> knots{};
    for (size_t i = 0; i <= size_t(degree); ++i) {
      poses[i] = PoseAt(double(i) / degree, turn, way, distance);
      knots[i] = &poses[i];
    }
    const M44d path = PoseAt(u, turn, way, distance);
    const bool followed =
        AffinePathIsFollowed(view, box, std::span(knots).first(size_t(degree) + 1), u, path);
    PathError largest;
    for (int v = 0; v < 60; ++v) {
      // Corners, and what lies between them.
      V3d p;
      for (int axis = 0; axis < 3; ++axis) {
        const double s = v < 8 ? (v >> axis) & 1 : unit(random);
        p[axis] = (1 - s) * low[axis] + s * high[axis];
      }
      std::array<RasterPoint, 4> curve;
      for (size_t i = 0; i <= size_t(degree); ++i) {
        curve[i] = view.RasterFromView(TransformPoint(poses[i], p));
      }
      InterpolateBezier(std::span(curve).first(size_t(degree) + 1));
      largest.Extend(PathErrorBetween(view, view.RasterFromView(TransformPoint(path, p)),
                                      BezierPoint(curve.data(), degree, u)));
    }
    EXPECT_TRUE(!followed || largest.IsWithinTolerance())
        << "round " << round << ": " << largest.pixels << " px, depth " << largest.depth;
    yes += followed;
    could_be_yes += largest.IsWithinTolerance();
  }
  // And it says so nearly always where it could.
  EXPECT_GT(yes, 500);
  EXPECT_GT(yes, 0.8 * could_be_yes);
}

TEST(AffinePath, SaysNothingOfWhatReachesTheNearPlaneOrHasNoBounds) {
  const FrameView view = View(true);
  const M44d before = PoseAt(0, 0, V3d(0), 1), after = PoseAt(1, 0, V3d(1e-6, 0, 0), 1);
  const std::array<const M44d*, 2> knots{&before, &after};
  const M44d path = PoseAt(0.5, 0, V3d(1e-6, 0, 0), 1);
  EXPECT_TRUE(AffinePathIsFollowed(view, Box3d(V3d(-0.1), V3d(0.1)), knots, 0.5, path));
  EXPECT_FALSE(AffinePathIsFollowed(view, Box3d(V3d(-1), V3d(1)), knots, 0.5, path));
  EXPECT_FALSE(AffinePathIsFollowed(view, Box3d(), knots, 0.5, path));
  Box3d infinite;
  infinite.makeInfinite();
  EXPECT_FALSE(AffinePathIsFollowed(view, infinite, knots, 0.5, path));
}

}  // namespace
}  // namespace shutterline::engine::affine_path_test
