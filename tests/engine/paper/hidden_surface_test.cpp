// Polygons, their order and what is seen of them, within one cell.
#include "worker/engine/paper/hidden_surface.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <random>

#include "common/math/tolerance.h"
#include "worker/engine/paper/depth_sort.h"

namespace shutterline::engine::paper {
namespace {

Polygon Add(PolygonArena& arena, std::initializer_list<CellPoint> points) {
  const uint32_t begin = arena.Begin();
  for (const CellPoint& p : points) arena.Append(p);
  return arena.End(begin);
}

Polygon RandomTriangle(PolygonArena& arena, std::mt19937_64& random) {
  std::uniform_real_distribution<double> unit(0, 1);
  CellPoint p[3];
  for (CellPoint& q : p) q = {unit(random), unit(random)};
  const double area = (p[1].u - p[0].u) * (p[2].v - p[0].v) - (p[1].v - p[0].v) * (p[2].u - p[0].u);
  return area > 0 ? Add(arena, {p[0], p[1], p[2]}) : Add(arena, {p[0], p[2], p[1]});
}

TEST(Polygons, SplitsShareTheirCut) {
  for (uint64_t seed = 1; seed <= 200; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> unit(-1, 1);
    PolygonArena arena;
    const Polygon whole = RandomTriangle(arena, random);
    const double angle = 4 * unit(random);
    const HalfPlane line{std::cos(angle), std::sin(angle), 0.5 * unit(random)};
    const PolygonSplit split = arena.Split(whole, line, kOnLine);
    const auto area = [&](const Polygon& p) { return p.count == 0 ? 0 : arena.MomentsOf(p).area; };
    EXPECT_NEAR(area(split.positive) + area(split.negative), area(whole), 1e-15);
    // New corners are the same bits on both sides and lie on the line.
    if (split.positive.count == 0 || split.negative.count == 0) continue;
    int shared = 0;
    for (uint32_t i = 0; i < split.positive.count; ++i) {
      for (uint32_t j = 0; j < split.negative.count; ++j) {
        const CellPoint& p = arena.At(split.positive, i);
        const CellPoint& q = arena.At(split.negative, j);
        if (p.u == q.u && p.v == q.v) {
          ++shared;
          EXPECT_NEAR(line.At(p), 0, kOnLine);
        }
      }
    }
    EXPECT_EQ(shared, 2);
  }
}

TEST(Polygons, MomentsOfASquare) {
  PolygonArena arena;
  const PolygonMoments m = arena.MomentsOf(Add(arena, {{0.5, 0.25}, {1, 0.25}, {1, 0.75}, {0.5, 0.75}}));
  EXPECT_DOUBLE_EQ(m.area, 0.25);
  EXPECT_DOUBLE_EQ(m.u / m.area, 0.75);
  EXPECT_DOUBLE_EQ(m.v / m.area, 0.5);
}

TEST(HiddenSurfaces, UnionOfRandomTrianglesIsThatOfPoints) {
  // The area that polygons cover together, in any order, against counting a fine grid of points.
  for (uint64_t seed = 1; seed <= 32; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937_64 random(seed);
    PolygonArena arena;
    std::vector<Polygon> polygons;
    for (int i = 0; i < 12; ++i) polygons.push_back(RandomTriangle(arena, random));
    HiddenSurface surface;
    surface.Clear();
    std::vector<VisibleFragment> fragments;
    double covered = 0;
    for (uint32_t i = 0; i < polygons.size(); ++i)
      covered += surface.Insert(polygons[i], i, arena, fragments);

    constexpr int kGrid = 256;
    int inside = 0;
    for (int i = 0; i < kGrid * kGrid; ++i) {
      const CellPoint at{(i % kGrid + 0.5) / kGrid, (i / kGrid + 0.5) / kGrid};
      for (const Polygon& p : polygons) {
        bool in = true;
        for (uint32_t k = 0; k < 3; ++k) {
          const CellPoint& a = arena.At(p, k);
          const CellPoint& b = arena.At(p, (k + 1) % 3);
          in &= (b.u - a.u) * (at.v - a.v) - (b.v - a.v) * (at.u - a.u) >= 0;
        }
        if (in) {
          ++inside;
          break;
        }
      }
    }
    EXPECT_NEAR(covered, double(inside) / (kGrid * kGrid), 4e-3);
    double sum = 0;
    for (const VisibleFragment& f : fragments) sum += f.area;
    EXPECT_NEAR(sum, covered, 1e-12);
    // Again: all of it is hidden now.
    for (uint32_t i = 0; i < polygons.size(); ++i) {
      EXPECT_LE(surface.Insert(polygons[i], i, arena, fragments), 1e-12);
    }
  }
}

TEST(DepthSorts, FrontToBackAtEveryPoint) {
  // Random planes that intersect: at every point the first polygon that covers it is the nearest.
  for (uint64_t seed = 1; seed <= 64; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> unit(0, 1);
    PolygonArena arena;
    DepthSort sort;
    std::vector<CellPlane> planes;
    for (uint32_t i = 0; i < 10; ++i) {
      CellPolygon p;
      p.polygon = Add(arena, {{0, 0}, {1, 0}, {1, 1}, {0, 1}});
      p.plane = {unit(random), unit(random) - 0.5, unit(random) - 0.5};
      p.index = p.id = i;
      planes.push_back(p.plane);
      sort.Insert(p, arena);
    }
    HiddenSurface surface;
    surface.Clear();
    std::vector<VisibleFragment> fragments;
    sort.FrontToBack([&](const CellPolygon& p) {
      surface.Insert(p.polygon, p.index, arena, fragments);
      return true;
    });
    double sum = 0;
    for (const VisibleFragment& f : fragments) {
      sum += f.area;
      if (f.area < 1e-9) continue;
      for (const CellPlane& plane : planes) {
        EXPECT_LE(plane.At({f.u, f.v}), planes[f.index].At({f.u, f.v}) + 1e-12);
      }
    }
    EXPECT_NEAR(sum, 1, 1e-12);
  }
}

TEST(DepthSorts, EqualPlanesGoByTheirId) {
  for (const bool lower_first : {false, true}) {
    PolygonArena arena;
    DepthSort sort;
    for (const uint32_t id : lower_first ? std::vector<uint32_t>{3, 7} : std::vector<uint32_t>{7, 3}) {
      CellPolygon p;
      p.polygon = Add(arena, {{0, 0}, {1, 0}, {1, 1}, {0, 1}});
      p.plane = {0.3, 0.1, 0.7};
      p.index = p.id = id;
      sort.Insert(p, arena);
    }
    std::vector<uint32_t> order;
    sort.FrontToBack([&](const CellPolygon& p) {
      order.push_back(p.id);
      return true;
    });
    EXPECT_EQ(order, (std::vector<uint32_t>{3, 7}));
  }
}

}  // namespace
}  // namespace shutterline::engine::paper
