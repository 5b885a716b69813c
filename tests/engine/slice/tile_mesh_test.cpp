#include "worker/engine/slice/tile_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <vector>

#include "common/math/tolerance.h"
#include "tests/support/frame_scene_builder.h"
#include "worker/engine/slice/moving_vertices.h"

namespace shutterline::engine::tile_mesh_test {
namespace {

/// Triangles that rest, move, bend in several pieces, pass the near and the far plane, and, where `reach` is
/// large, have corners far outside of the frame.
std::shared_ptr<const FrameScene> RandomScene(std::mt19937_64& random, double reach) {
  std::uniform_real_distribution<double> unit(-1, 1);
  FrameSceneBuilder builder(random() % 4 == 0 ? OrthographicView(96, 96, 1, 0.1, 5)
                                              : PerspectiveView(96, 96, 0.9, 0.2, random() % 2 == 0 ? 0 : 4));
  for (int i = 0; i < 40; ++i) {
    const V3d center(1.5 * unit(random), 1.5 * unit(random), -2.5 + 3 * unit(random));
    const double speed = random() % 3 == 0 ? 0 : 2 * std::abs(unit(random));
    const double size = 0.5 * (random() % 4 == 0 ? reach : 1);
    std::array<V3d, 3> open, close;
    for (size_t k = 0; k < 3; ++k) {
      open[k] = center + V3d(unit(random), unit(random), 0) * size + V3d(0, 0, 0.5 * unit(random));
      close[k] = open[k] + V3d(unit(random), unit(random), unit(random)) * speed;
    }
    if (random() % 2 == 0) {
      builder.AddViewTriangle(open, close);
      continue;
    }
    const int degree = 1 + int(random() % 3), pieces = 1 << random() % 3;
    std::vector<RasterPoint> curves;
    for (size_t k = 0; k < 3; ++k) {
      for (int c = 0; c <= degree * pieces; ++c) {
        const V3d bend(unit(random), unit(random), unit(random));
        curves.push_back(builder.Raster(open[k] + (close[k] - open[k]) * (c / double(degree * pieces)) +
                                        bend * (0.5 * speed)));
      }
    }
    builder.AddCurvedMesh(curves, degree, pieces, {{0, 1, 2}});
  }
  return builder.Build();
}

std::vector<uint32_t> AllOf(const FrameScene& frame) {
  std::vector<uint32_t> all(frame.triangles.size());
  std::iota(all.begin(), all.end(), 0u);
  return all;
}

/// A point of a triangle at an instant.
RasterPoint PointAt(const FrameScene& frame, uint32_t id, double t, double b1, double b2) {
  const FrameTriangle& triangle = frame.triangles[id];
  const FramePrimitive& primitive = frame.primitives[triangle.primitive];
  const double b[3] = {1 - b1 - b2, b1, b2};
  RasterPoint p;
  for (size_t k = 0; k < 3; ++k) p = p + b[k] * frame.VertexAt(primitive, triangle.vertices[k], t);
  return p;
}

void ExpectNumbers(const TileMesh& mesh) {
  for (const TileVertex& vertex : mesh.vertices()) {
    EXPECT_TRUE(std::isfinite(vertex.nearest) && std::isfinite(vertex.motion_pixels));
    for (size_t p = 0; p < TileVertex::kPlanes; ++p) {
      EXPECT_TRUE(vertex.in[p] >= 0 && vertex.in[p] <= 1.0001f);
      EXPECT_TRUE(vertex.out[p] >= 0 && vertex.out[p] <= 1.0001f);
    }
    for (size_t f = 0; f < 2; ++f)
      EXPECT_FALSE(std::isnan(vertex.row_low[f]) || std::isnan(vertex.row_high[f]));
  }
}

TEST(TileMesh, BoundsHoldWhateverIsSeen) {
  int64_t seen = 0;
  size_t kept_of_many = 0, many = 0;
  TileMesh mesh;  // One for all: what a tile leaves behind must not matter.
  for (uint64_t seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> unit(0, 1);
    const auto frame = RandomScene(random, seed % 3 == 0 ? 0x1p20 : 1);
    const LinePattern& pattern = LinePattern::Get(seed % 2 == 0 ? PatternKind::kRgls : PatternKind::k2h2v);
    const TileRect rect{int(random() % 64), int(random() % 64), 32, 32};
    const std::vector<PrimitiveTraits> traits(frame->primitives.size());
    const std::vector<uint32_t> all = AllOf(*frame);
    mesh.Build({*frame, traits, rect, all}, pattern);
    ExpectNumbers(mesh);
    std::vector<const TileMeshTriangle*> kept(all.size(), nullptr);
    for (const TileMeshTriangle& triangle : mesh.triangles()) {
      ASSERT_EQ(kept[triangle.id], nullptr);
      kept[triangle.id] = &triangle;
      for (size_t k = 0; k < 3; ++k) {
        EXPECT_EQ(mesh.vertices()[triangle.vertices[k]].vertex, frame->triangles[triangle.id].vertices[k]);
      }
    }
    many += all.size();
    kept_of_many += mesh.triangles().size();

    for (const uint32_t id : all) {
      for (int i = 0; i < 400; ++i) {
        const double t = unit(random), b1 = unit(random), b2 = (1 - b1) * unit(random);
        const RasterPoint p = PointAt(*frame, id, t, b1, b2);
        if (p.w < p.z || p.z < frame->view.FarDepth() * p.w) continue;
        const double x = p.x / p.w - rect.x, y = p.y / p.w - rect.y;
        if (x < 0 || x > rect.width || y < 0 || y > rect.height) continue;
        ++seen;
        ASSERT_NE(kept[id], nullptr) << "triangle " << id << " is seen at " << t;
        ASSERT_LE(kept[id]->t_in, t);
        ASSERT_GE(kept[id]->t_out, t);
        ASSERT_LE(p.z / p.w, double(kept[id]->nearest));
        for (size_t f = 0; f < 2; ++f) {
          const LineFamily& family = pattern.families()[f];
          const double row = (family.major_is_x ? y : x) - family.slope * (family.major_is_x ? x : y);
          ASSERT_LE(kept[id]->row_low[f], row);
          ASSERT_GE(kept[id]->row_high[f], row);
        }
      }
    }
  }
  EXPECT_GT(seen, 20000);
  EXPECT_LT(kept_of_many, many * 9 / 10) << "bounds that hold everything would be useless";
}

TEST(TileMesh, VerticesAreInsideAPlaneOnlyWithinItsTimes) {
  TileMesh mesh;
  for (uint64_t seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937_64 random(seed);
    const auto frame = RandomScene(random, seed % 3 == 0 ? 0x1p20 : 1);
    const TileRect rect{32, 32, 32, 32};
    const std::vector<PrimitiveTraits> traits(frame->primitives.size());
    mesh.Build({*frame, traits, rect, AllOf(*frame)}, LinePattern::Get(PatternKind::k1h1v));
    for (const TileVertex& vertex : mesh.vertices()) {
      const FramePrimitive& primitive = frame->primitives[vertex.primitive];
      for (int i = 0; i <= 64; ++i) {
        const double t = i / 64.0;
        const RasterPoint p = frame->VertexAt(primitive, vertex.vertex, t);
        const double w = std::abs(p.w);
        const std::array<double, 6> inside{p.x - 32 * p.w, 64 * p.w - p.x,
                                           p.y - 32 * p.w, 64 * p.w - p.y,
                                           p.w - p.z,      p.z - frame->view.FarDepth() * p.w};
        for (size_t k = 0; k < 6; ++k) {
          if (inside[k] <= 1e-9 * (w + std::abs(p.x) + std::abs(p.y))) continue;
          ASSERT_LE(double(vertex.in[k]), t) << "plane " << k;
          ASSERT_GE(double(vertex.out[k]), t) << "plane " << k;
          if (vertex.in_front) {
            ASSERT_LE(p.z / p.w, vertex.nearest + 1e-12);
          }
        }
      }
    }
  }
}

TEST(TileMesh, IsSortedByDepthThenId) {
  std::mt19937_64 random(5);
  FrameSceneBuilder builder(PerspectiveView(64, 64));
  for (int i = 0; i < 300; ++i) {
    const double distance = 1 + double(random() % 40);
    builder.AddTriangle({{{4, 4, distance}, {20, 5, distance}, {6, 19, distance + 1}}});
  }
  const auto frame = builder.Build();
  std::vector<uint32_t> candidates = AllOf(*frame);
  std::shuffle(candidates.begin(), candidates.end(), random);
  const std::vector<PrimitiveTraits> traits(frame->primitives.size());
  TileMesh mesh;
  mesh.Build({*frame, traits, {0, 0, 32, 32}, candidates}, LinePattern::Get(PatternKind::k1h1v));
  ASSERT_EQ(mesh.triangles().size(), 300u);
  ASSERT_EQ(mesh.ids().size(), Padded(300));
  for (size_t i = 0; i < 300; ++i) {
    const TileMeshTriangle& b = mesh.triangles()[i];
    EXPECT_EQ(mesh.ids()[i], b.id);
    if (i == 0) continue;
    const TileMeshTriangle& a = mesh.triangles()[i - 1];
    EXPECT_TRUE(a.nearest > b.nearest || (a.nearest == b.nearest && a.id < b.id));
  }
}

TEST(TileMesh, MotionFarOutsideCostsNothing) {
  FrameSceneBuilder builder(PerspectiveView(96, 96, 1.0, 0.1));
  builder.AddTriangle({Corner{-50000, 40, 1}, Corner{48, 40, 1}, Corner{48, 60, 1}},
                      {Corner{-20000, 40, 1}, Corner{48, 40, 1}, Corner{48, 60, 1}});
  builder.AddTriangle({Corner{-5000, 40, 1}, Corner{48, 40, 1}, Corner{48, 60, 1}},
                      {Corner{28, 40, 1}, Corner{48, 40, 1}, Corner{48, 60, 1}});
  builder.AddTriangle({Corner{40, 40, 1}, Corner{48, 40, 1}, Corner{48, 60, 1}},
                      {Corner{43, 44, 1}, Corner{48, 40, 1}, Corner{48, 60, 1}});
  const auto frame = builder.Build();
  const std::vector<PrimitiveTraits> traits(frame->primitives.size());
  TileMesh mesh;
  mesh.Build({*frame, traits, {32, 32, 32, 32}, AllOf(*frame)}, LinePattern::Get(PatternKind::kRgls));
  std::array<double, 3> motion{-1, -1, -1};
  for (const TileMeshTriangle& triangle : mesh.triangles()) {
    motion[triangle.id] = double(triangle.motion_pixels);
  }
  EXPECT_GE(motion[0], 0);
  EXPECT_LT(motion[0], 1);
  // From the border of the surroundings to 28.
  EXPECT_NEAR(motion[1], kMotionGuardPixels + 28 - 32, 1e-3);
  EXPECT_NEAR(motion[2], 5, 1e-3);
}

}  // namespace
}  // namespace shutterline::engine::tile_mesh_test
