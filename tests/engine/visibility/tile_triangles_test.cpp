#include "worker/engine/visibility/tile_triangles.h"

#include <gtest/gtest.h>

#include <numeric>
#include <random>
#include <vector>

#include "common/math/tolerance.h"
#include "tests/support/frame_scene_builder.h"
#include "worker/engine/visibility/segment.h"

namespace shutterline::engine {
namespace {

constexpr PatternKind kAllPatterns[] = {PatternKind::k1h1v, PatternKind::k2h2v,   PatternKind::k4h4v,
                                        PatternKind::k8h8v, PatternKind::k16h16v, PatternKind::kRgls};

/// A scene of triangles, some through the near plane, some at rest, some fast.
std::shared_ptr<const FrameScene> RandomScene(std::mt19937_64& random, bool perspective) {
  std::uniform_real_distribution<double> unit(-1, 1);
  FrameSceneBuilder builder(perspective ? PerspectiveView(96, 96, 0.9, 0.2, random() % 2 == 0 ? 0 : 4)
                                        : OrthographicView(96, 96, 1, 0.1, 5));
  for (int i = 0; i < 40; ++i) {
    const V3d center(1.5 * unit(random), 1.5 * unit(random), -2.5 + 3 * unit(random));
    const double speed = random() % 3 == 0 ? 0 : 2 * std::abs(unit(random));
    std::array<V3d, 3> open;
    std::array<V3d, 3> close;
    for (size_t k = 0; k < 3; ++k) {
      open[k] = center + V3d(unit(random), unit(random), unit(random)) * 0.5;
      close[k] = open[k] + V3d(unit(random), unit(random), unit(random)) * speed;
    }
    if (random() % 3 > 0) {
      builder.AddViewTriangle(open, close);
      continue;
    }
    const int degree = 1 + int(random() % 3), pieces = 1 << random() % 3;
    std::vector<RasterPoint> curves;
    for (size_t k = 0; k < 3; ++k) {
      for (int c = 0; c <= degree * pieces; ++c) {
        const V3d there = open[k] + (close[k] - open[k]) * (c / double(degree * pieces)) +
                          V3d(unit(random), unit(random), unit(random)) * (0.5 * speed);
        curves.push_back(builder.Raster(there));
      }
    }
    builder.AddCurvedMesh(curves, degree, pieces, {{0, 1, 2}});
  }
  return builder.Build();
}

TEST(TileTriangles, LineRangesAreConservative) {
  // Whatever segment exists on any line at any time lies within the bounds that the tile put on its
  // triangle: line numbers, time, depth. Triangles that the tile left out have no segment at all.
  int64_t segments = 0;
  for (uint64_t seed = 1; seed <= 32; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937_64 random(seed);
    const auto frame = RandomScene(random, seed % 4 != 0);
    const LinePattern& pattern = LinePattern::Get(kAllPatterns[seed % std::size(kAllPatterns)]);
    const TileRect rect{int(random() % 64), int(random() % 64), 32, 32};
    const std::vector<PrimitiveTraits> traits(frame->primitives.size());
    std::vector<uint32_t> all(frame->triangles.size());
    std::iota(all.begin(), all.end(), 0u);
    TileTriangles tile;
    SetUpTile(*frame, traits, pattern, rect, all, tile);
    for (size_t i = 1; i < tile.triangles.size(); ++i) {
      ASSERT_GE(tile.triangles[i - 1].nearest_depth, tile.triangles[i].nearest_depth);
    }
    std::vector<const TileTriangle*> kept(all.size(), nullptr);
    for (const TileTriangle& triangle : tile.triangles) kept[triangle.id] = &triangle;

    for (const uint32_t id : all) {
      // The triangle as the tile would have it, without its bounds.
      const FramePrimitive& primitive = frame->primitives[frame->triangles[id].primitive];
      TileTriangle bare;
      bare.crosses_near = true;
      bare.moves = primitive.degree > 0;
      for (int k = 0; k < 3; ++k) {
        const uint32_t vertex = frame->triangles[id].vertices[size_t(k)];
        for (int e = 0; e <= int(bare.moves); ++e) {
          RasterPoint p =
              frame->ControlPoint(primitive, vertex, e == 0 ? 0 : primitive.PointsPerVertex() - 1);
          p.x -= rect.x * p.w;
          p.y -= rect.y * p.w;
          (e == 0 ? bare.open : bare.close)[size_t(k)] = p;
        }
      }
      for (const TileLine& line : pattern.LinesIn(rect)) {
        const SegmentLine segment_line = MakeSegmentLine(pattern, line);
        for (int i = 0; i < 8; ++i) {
          const double t = (i + line.instant_offset) / 8;
          if (primitive.degree * primitive.pieces > 1) {
            // Where the triangle is now, as one at rest.
            bare.moves = false;
            for (size_t k = 0; k < 3; ++k) {
              bare.open[k] = frame->VertexAt(primitive, frame->triangles[id].vertices[k], t);
              bare.open[k].x -= rect.x * bare.open[k].w;
              bare.open[k].y -= rect.y * bare.open[k].w;
            }
          }
          LineSegment segment;
          if (!MakeSegment(bare, 0, frame->view.FarDepth(), segment_line, t, &segment, nullptr)) continue;
          ++segments;
          ASSERT_NE(kept[id], nullptr)
              << "triangle " << id << " was left out but covers line " << line.number;
          const TileTriangle& bounded = *kept[id];
          ASSERT_LE(bounded.first_line[size_t(line.family)], line.number);
          ASSERT_GE(bounded.last_line[size_t(line.family)], line.number);
          ASSERT_LE(bounded.t_in, t);
          ASSERT_GE(bounded.t_out, t);
          const double l0 = segment.begin / double(kSubpixelsPerPixel);
          const double l1 = segment.end / double(kSubpixelsPerPixel);
          ASSERT_LE(std::max(segment.DepthAt(l0), segment.DepthAt(l1)), bounded.nearest_depth);
          // And the tile's own triangle gives the same segment.
          LineSegment again;
          ASSERT_TRUE(MakeSegment(bounded, 0, frame->view.FarDepth(), segment_line, t, &again, nullptr));
          const int rounding = primitive.degree * primitive.pieces > 1 ? 64 : 0;  // 2^-18 px.
          ASSERT_NEAR(again.begin, segment.begin, rounding);
          ASSERT_NEAR(again.end, segment.end, rounding);
        }
      }
    }
  }
  EXPECT_GT(segments, 10000) << "the scenes show too little to prove anything";
}

TEST(TileTriangles, MotionFarOutsideCostsNothing) {
  // Part of a floor whose near corner travels tens of thousands of pixels below the frame, on lines that
  // see it move by little.
  FrameSceneBuilder builder(PerspectiveView(96, 96, 1.0, 0.1));
  const V3d left(-8, -1, -30);
  const V3d right(8, -1, -30);
  builder.AddViewTriangle({left, V3d(0, -1, -0.11), right}, {left, V3d(0.05, -1, -0.11), right});
  const auto frame = builder.Build();
  ASSERT_GT(frame->primitives[0].motion_pixels, 0);
  const uint32_t id = 0;
  const std::vector<PrimitiveTraits> traits(1);
  TileTriangles tile;
  SetUpTile(*frame, traits, LinePattern::Get(PatternKind::kRgls), {32, 64, 32, 32}, {&id, 1}, tile);
  ASSERT_EQ(tile.triangles.size(), 1u);
  EXPECT_LE(tile.triangles[0].motion_pixels, kMostMotionPixels);
  // A corner that stays beyond the guarded surroundings does not count at all.
  FrameSceneBuilder far_off(PerspectiveView(96, 96, 1.0, 0.1));
  far_off.AddTriangle({Corner{-50000, 40, 1}, Corner{48, 40, 1}, Corner{48, 60, 1}},
                      {Corner{-20000, 40, 1}, Corner{48, 40, 1}, Corner{48, 60, 1}});
  const auto other = far_off.Build();
  SetUpTile(*other, traits, LinePattern::Get(PatternKind::kRgls), {32, 32, 32, 32}, {&id, 1}, tile);
  ASSERT_EQ(tile.triangles.size(), 1u);
  EXPECT_LT(tile.triangles[0].motion_pixels, 1);
}

}  // namespace
}  // namespace shutterline::engine
