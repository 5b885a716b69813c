// Patches of single triangles on one line, against exact segments and closed forms.
#include "worker/engine/paper/depth_patch.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "common/math/tolerance.h"
#include "worker/engine/paper/patch_piece.h"

namespace shutterline::engine::paper {
namespace {

const SegmentLine kLine{
    .major_is_x = true, .slope = 0, .intercept = 0.5, .begin = 0, .end = 8 * kSubpixelsPerPixel};

RasterPoint At(double x, double y, double d = 0.5, double w = 1) {
  return {x * w, y * w, d * w, w};
}

TileTriangle Moving(const std::array<RasterPoint, 3>& open, const std::array<RasterPoint, 3>& close) {
  TileTriangle triangle;
  triangle.moves = true;
  triangle.open = open;
  triangle.close = close;
  return triangle;
}

double Area(std::span<const Slab> slabs) {
  double area = 0;
  for (const Slab& s : slabs) {
    area += (s.t1 - s.t0) * 0.5 * (s.right0 - s.left0 + s.right1 - s.left1);
  }
  return area;
}

TEST(Patches, TranslationIsOneParallelogram) {
  DepthPatch patch;
  patch.Begin(kLine, {});
  patch.Make(Moving({At(1, -10), At(2, -10), At(1, 90)}, {At(4, -10), At(5, -10), At(4, 90)}), 0);
  ASSERT_EQ(patch.slabs().size(), 1u);
  const Slab& slab = patch.slabs()[0];
  EXPECT_EQ(slab.left0, 1);
  EXPECT_EQ(slab.left1, 4);
  EXPECT_NEAR(slab.right0 - slab.left0, 0.895, 1e-6);
}

TEST(Patches, FacingFlipCutsTheSlab) {
  // The sides trade places at t = ½: two triangles, and one of them where back sides are not drawn.
  const auto corners = [](double w) -> std::array<RasterPoint, 3> {
    return {At(3, -50), At(3, 50), At(3 + w, 0.5)};
  };
  for (const bool cull : {false, true}) {
    TileTriangle triangle = Moving(corners(2), corners(-2));
    triangle.cull_back = cull;
    DepthPatch patch;
    patch.Begin(kLine, {});
    patch.Make(triangle, 0);
    EXPECT_NEAR(Area(patch.slabs()), cull ? 0.5 : 1, 1e-6);
  }
}

TEST(Patches, EdgeInThePlaneForAnInstant) {
  // Row 6: the edge lies in the plane at ½; its crossing stays at l = ½ on both sides of that instant.
  DepthPatch patch;
  patch.Begin(kLine, {});
  patch.Make(Moving({At(0, 1), At(1, 0), At(0.5, -1e9)}, {At(0, 0), At(1, 1), At(0.5, -1e9)}), 0);
  EXPECT_NEAR(Area(patch.slabs()), 0.5, 1e-6);
}

TEST(Patches, ParallelEdgeAwayFromTheLine) {
  // Row 5: above the line at all times, parallel to it at ½.
  DepthPatch patch;
  patch.Begin(kLine, {});
  patch.Make(Moving({At(0.2, 1.5), At(0.8, 0.5), At(0.5, 3)}, {At(0.2, 0.5), At(0.8, 1.5), At(0.5, 3)}), 0);
  EXPECT_TRUE(patch.slabs().empty());
}

TEST(Patches, FarOutlinesAreCut) {
  // Corners a billion pixels away: sides are cut near the line, with the depth that is there.
  DepthPatch patch;
  patch.Begin(kLine, {});
  patch.Make(Moving({At(-1e9, -1e9, 0.25), At(1e9, -1e9, 0.75), At(0, 1e9, 0.5)},
                    {At(-1e9 + 1, -1e9, 0.25), At(1e9 + 1, -1e9, 0.75), At(1, 1e9, 0.5)}),
             0);
  ASSERT_FALSE(patch.slabs().empty());
  for (const Slab& slab : patch.slabs()) {
    for (const double l : {slab.left0, slab.left1}) EXPECT_EQ(l, -kOutlineGuardPixels);
    for (const double l : {slab.right0, slab.right1}) EXPECT_EQ(l, 8 + kOutlineGuardPixels);
    EXPECT_NEAR(PatchPiece(slab, 0, 0).DepthAt(4, 0.5 * (slab.t0 + slab.t1)), 0.5, 1e-6);
  }
}

TEST(Patches, FollowTheExactSegmentsWithinTolerance) {
  // Random triangles, some of which pass the near plane: at random instants the patch is where the segment
  // is, up to twice the tolerance (the chord's middle is at least half as far off as its worst point).
  for (const double tolerance : {0.1, 0.01}) {
    int64_t compared = 0;
    int64_t off = 0;
    for (uint64_t seed = 1; seed <= 400; ++seed) {
      std::mt19937_64 random(seed);
      std::uniform_real_distribution<double> unit(0, 1);
      const bool near = seed % 3 == 0;
      std::array<RasterPoint, 3> open, close;
      for (size_t i = 0; i < 3; ++i) {
        const auto point = [&] {
          const double w = near ? 2.5 * unit(random) - 0.5 : 1 + unit(random);
          return RasterPoint{(10 * unit(random) - 1) * std::abs(w), (4 * unit(random) - 1.5) * std::abs(w),
                             0.1, w};
        };
        open[i] = point();
        close[i] = point();
      }
      TileTriangle triangle = Moving(open, close);
      triangle.crosses_near = near;
      DepthPatch patch;
      patch.Begin(kLine, {.outline_tolerance = tolerance, .depth_tolerance = tolerance / 10});
      patch.Make(triangle, 0);
      for (int i = 0; i < 50; ++i) {
        const double t = unit(random);
        LineSegment segment;
        double begin = 0, end = 0;
        if (MakeSegment(triangle, 0, 0, kLine, t, &segment, nullptr)) {
          begin = std::clamp(segment.l0, 0.0, 8.0);
          end = std::clamp(segment.l1, 0.0, 8.0);
        }
        double patch_begin = 0, patch_end = 0;
        for (const Slab& slab : patch.slabs()) {
          if (t < slab.t0 || t >= slab.t1) continue;
          const double s = (t - slab.t0) / (slab.t1 - slab.t0);
          patch_begin = std::clamp(slab.left0 + s * (slab.left1 - slab.left0), 0.0, 8.0);
          patch_end = std::clamp(slab.right0 + s * (slab.right1 - slab.right0), 0.0, 8.0);
        }
        if (begin == end && patch_begin == patch_end) continue;
        ++compared;
        if (begin == end) begin = end = patch_begin;
        const bool far =
            std::abs(begin - patch_begin) > 2 * tolerance || std::abs(end - patch_end) > 2 * tolerance;
        off += far;
      }
    }
    EXPECT_GT(compared, 5000);
    // Where perspective bends a side both ways its middle may hide that; such are few.
    EXPECT_LE(double(off), 0.005 * double(compared)) << tolerance;
  }
}

TEST(Patches, NeighboursShareTheirOutline) {
  // Two triangles at an edge, their vertices in different orders: the points of the edge's connections are
  // equal bits.
  for (uint64_t seed = 1; seed <= 200; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> unit(0, 1);
    const auto point = [&] {
      return At(10 * unit(random) - 1, 4 * unit(random) - 1.5, unit(random), 0.5 + unit(random));
    };
    LinearMotion first, second;
    for (size_t i = 0; i < 3; ++i) {
      first.open[i] = point();
      first.close[i] = point();
    }
    // Edge (0, 1) of the first is edge (2, 0) of the second.
    second.open = {first.open[1], point(), first.open[0]};
    second.close = {first.close[1], point(), first.close[0]};
    std::swap(second.open[0], second.open[2]);
    std::swap(second.close[0], second.close[2]);
    Outlines a, b;
    a.Begin(kLine, {});
    b.Begin(kLine, {});
    a.Make(MovingSection(first, kLine, 0), false);
    b.Make(MovingSection(second, kLine, 0), false);
    std::vector<OutlinePoint> of_a, of_b;
    for (const Connection& c : a.connections()) {
      if (c.edge == 0) of_a.insert(of_a.end(), a.PointsOf(c), a.PointsOf(c) + c.count);
    }
    for (const Connection& c : b.connections()) {
      if (c.edge == 2) of_b.insert(of_b.end(), b.PointsOf(c), b.PointsOf(c) + c.count);
    }
    ASSERT_EQ(of_a.size(), of_b.size());
    for (size_t i = 0; i < of_a.size(); ++i) {
      EXPECT_EQ(of_a[i].t, of_b[i].t);
      EXPECT_EQ(of_a[i].l, of_b[i].l);
      EXPECT_EQ(of_a[i].d, of_b[i].d);
    }
  }
}

}  // namespace
}  // namespace shutterline::engine::paper
