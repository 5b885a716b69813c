#include "worker/engine/accel/frustum_cull.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/support/frame_scene_builder.h"

namespace shutterline::engine {
namespace {

using Side = TileFrustum::Side;

bool PointIsInside(const FrameView& view, const TileRect& rect, const V3d& p) {
  const RasterPoint r = view.RasterFromView(p);
  return r.w >= r.z && r.z >= view.FarDepth() * r.w && r.x >= rect.x * r.w && r.y >= rect.y * r.w &&
         r.x <= (rect.x + rect.width) * r.w && r.y <= (rect.y + rect.height) * r.w;
}

TEST(TileFrustum, BoxesAgreeWithTheirPoints) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(0, 1);
  const TileRect rect{32, 64, 32, 21};
  int outside = 0, inside = 0;
  for (const bool perspective : {true, false}) {
    const FrameView view =
        perspective ? PerspectiveView(100, 85, 0.9, 0.2, 40) : OrthographicView(100, 85, 3, 0.2, 40);
    const double scale = 0.25;
    const TileFrustum frustum(view, rect, scale);
    for (int i = 0; i < 4000; ++i) {
      const double distance = 50 * unit(random) - 5, spread = perspective ? distance * 0.5 : 3;
      const double size = unit(random) < 0.5 ? 0.3 : 5;
      const V3d corner(spread * (2 * unit(random) - 1), spread * (2 * unit(random) - 1), -distance);
      ViewBounds box;
      for (int axis = 0; axis < 3; ++axis) {
        box.lower[axis] = float(corner[axis] / scale);
        box.upper[axis] = float((corner[axis] + size * unit(random)) / scale);
      }
      const Side side = frustum.ClassifyBox(box);
      outside += side == Side::kOutside;
      inside += side == Side::kInside;
      for (int k = 0; k < 50; ++k) {
        V3d p;
        for (int axis = 0; axis < 3; ++axis) {
          p[axis] = scale * (box.lower[axis] + unit(random) * (double(box.upper[axis]) - box.lower[axis]));
        }
        const bool point_is_inside = PointIsInside(view, rect, p);
        if (side == Side::kOutside) {
          EXPECT_FALSE(point_is_inside) << "box " << i;
        } else if (side == Side::kInside) {
          EXPECT_TRUE(point_is_inside) << "box " << i;
        }
      }
    }
  }
  EXPECT_GT(outside, 4000);
  EXPECT_GT(inside, 20);
}

/// Whether the tile (32, 32, 32, 32) of a 96 × 96 frame may see a triangle.
bool MayContain(const FrameView& view, const std::array<Corner, 3>& open,
                const std::array<Corner, 3>& close) {
  FrameSceneBuilder builder(view);
  builder.AddTriangle(open, close);
  const auto frame = builder.Build();
  return TileFrustum(view, {32, 32, 32, 32}, 1).MayContain(frame->control_points);
}

TEST(TileFrustum, TrianglesAreCulledByOnePlaneOverTheWholeShutter) {
  const FrameView view = PerspectiveView(96, 96, 0.8, 0.1, 100);
  const auto at = [](double x, double y, double distance) {
    return std::array<Corner, 3>{{{x, y, distance}, {x + 3, y, distance}, {x, y + 3, distance}}};
  };
  EXPECT_TRUE(MayContain(view, at(40, 40, 2), at(45, 40, 2)));
  EXPECT_FALSE(MayContain(view, at(10, 40, 2), at(20, 40, 2))) << "left";
  EXPECT_FALSE(MayContain(view, at(65, 40, 2), at(70, 40, 2))) << "right";
  EXPECT_FALSE(MayContain(view, at(40, 10, 2), at(40, 20, 2))) << "above";
  EXPECT_FALSE(MayContain(view, at(40, 65, 2), at(40, 70, 2))) << "below";
  EXPECT_FALSE(MayContain(view, at(40, 40, .05), at(40, 40, .09))) << "before the near plane";
  EXPECT_FALSE(MayContain(view, at(40, 40, 101), at(40, 40, 200))) << "behind the far plane";
  EXPECT_FALSE(MayContain(view, at(40, 40, -3), at(40, 40, -2))) << "behind the eye";
  EXPECT_TRUE(MayContain(view, at(10, 40, 2), at(80, 40, 2))) << "passes through";
  EXPECT_TRUE(MayContain(view, at(40, 40, -1), at(40, 40, 2))) << "comes from behind the eye";
  EXPECT_TRUE(MayContain(view, at(64, 40, 2), at(70, 40, 2))) << "touches at shutter open";
}

}  // namespace
}  // namespace shutterline::engine
