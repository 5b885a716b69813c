#include "worker/engine/accel/bvh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>

#include "tests/support/frame_scene_builder.h"

namespace shutterline::engine {
namespace {

struct RasterBounds {
  double x0 = INFINITY, y0 = INFINITY, x1 = -INFINITY, y1 = -INFINITY;

  bool Overlaps(const TileRect& r) const {
    return x1 > r.x && x0 < r.x + r.width && y1 > r.y && y0 < r.y + r.height;
  }
};

/// Keeps the part of a polygon where `height` is not negative.
template <typename Height>
std::vector<RasterPoint> Clip(const std::vector<RasterPoint>& polygon, Height height) {
  std::vector<RasterPoint> result;
  for (size_t i = 0; i < polygon.size(); ++i) {
    const RasterPoint& a = polygon[i];
    const RasterPoint& b = polygon[(i + 1) % polygon.size()];
    const double ha = height(a), hb = height(b);
    if (ha >= 0) result.push_back(a);
    if ((ha < 0) != (hb < 0)) result.push_back((1 / (ha - hb)) * (ha * b - hb * a));
  }
  return result;
}

/// Where a triangle is seen at an instant: clipped at both planes, then divided.
std::optional<RasterBounds> BoundsAt(const FrameScene& frame, const FrameTriangle& triangle, double t) {
  const FramePrimitive& primitive = frame.primitives[triangle.primitive];
  std::vector<RasterPoint> polygon;
  for (const uint32_t vertex : triangle.vertices) polygon.push_back(frame.VertexAt(primitive, vertex, t));
  const double far_depth = frame.view.FarDepth();
  polygon = Clip(polygon, [](const RasterPoint& p) { return p.w - p.z; });
  polygon = Clip(polygon, [&](const RasterPoint& p) { return p.z - far_depth * p.w; });
  if (polygon.empty()) return std::nullopt;
  RasterBounds bounds;
  for (const RasterPoint& p : polygon) {
    bounds.x0 = std::min(bounds.x0, p.x / p.w);
    bounds.x1 = std::max(bounds.x1, p.x / p.w);
    bounds.y0 = std::min(bounds.y0, p.y / p.w);
    bounds.y1 = std::max(bounds.y1, p.y / p.w);
  }
  return bounds;
}

struct RandomSceneOptions {
  int triangles = 300;
  double moving_fraction = 0.5;
  double curved_fraction = 0;
  double nearest = -3, farthest = 30;  ///< Distances of triangle centres; negative: behind the eye.
};

std::shared_ptr<const FrameScene> RandomScene(const FrameView& view, unsigned seed,
                                              const RandomSceneOptions& options = {}, double size = 1) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  const auto symmetric = [&] { return 2 * unit(random) - 1; };
  FrameSceneBuilder builder(view);
  for (int i = 0; i < options.triangles; ++i) {
    const double distance = options.nearest + (options.farthest - options.nearest) * unit(random);
    const double spread = view.perspective ? 0.7 * std::abs(distance) + 1 : 3;
    const V3d centre(spread * symmetric(), spread * symmetric(), -distance);
    const double radius = std::pow(10.0, -2 + 2.5 * unit(random));
    const V3d shift = 3 * unit(random) * V3d(symmetric(), symmetric(), symmetric());
    std::array<V3d, 3> open, close;
    for (int k = 0; k < 3; ++k) {
      open[k] = size * (centre + radius * V3d(symmetric(), symmetric(), symmetric()));
      close[k] = open[k] + size * (shift + 0.3 * radius * V3d(symmetric(), symmetric(), symmetric()));
    }
    if (unit(random) < options.curved_fraction) {
      const int degree = 1 + int(random() % 3), pieces = 1 << random() % 4;
      std::vector<RasterPoint> curves;
      for (size_t k = 0; k < 3; ++k) {
        for (int c = 0; c <= degree * pieces; ++c) {
          const V3d bend(symmetric(), symmetric(), symmetric());
          curves.push_back(builder.Raster(open[k] + (close[k] - open[k]) * (c / double(degree * pieces)) +
                                          size * 0.7 * bend));
        }
      }
      builder.AddCurvedMesh(curves, degree, pieces, {{0, 1, 2}});
    } else if (unit(random) < options.moving_fraction) {
      builder.AddViewTriangle(open, close);
    } else {
      builder.AddViewTriangle(open);
    }
  }
  return builder.Build();
}

std::unique_ptr<const Bvh> MustBuild(const std::shared_ptr<const FrameScene>& frame, int threads = 2) {
  absl::StatusOr<std::unique_ptr<const Bvh>> bvh = Bvh::Build(frame, threads);
  EXPECT_TRUE(bvh.ok()) << bvh.status();
  return *std::move(bvh);
}

std::vector<uint32_t> Collect(const Bvh& bvh, const TileRect& rect) {
  std::vector<uint32_t> triangles;
  bvh.CollectVisible(rect, triangles);
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}

/// Every triangle that is seen in a tile at one of many instants is collected for it, and none twice.
void ExpectNothingMissed(const std::shared_ptr<const FrameScene>& frame) {
  const std::unique_ptr<const Bvh> bvh = MustBuild(frame);
  const TileGrid grid{frame->view.width, frame->view.height};
  std::vector<std::vector<uint32_t>> collected;
  for (int tile = 0; tile < grid.Count(); ++tile) {
    collected.push_back(Collect(*bvh, grid.Rect(tile)));
    EXPECT_EQ(std::adjacent_find(collected[tile].begin(), collected[tile].end()), collected[tile].end())
        << "a triangle twice in tile " << tile;
  }
  constexpr int kInstants = 33;
  for (uint32_t i = 0; i < frame->triangles.size(); ++i) {
    for (int k = 0; k < kInstants; ++k) {
      const auto bounds = BoundsAt(*frame, frame->triangles[i], double(k) / (kInstants - 1));
      if (!bounds) continue;
      for (int tile = 0; tile < grid.Count(); ++tile) {
        if (!bounds->Overlaps(grid.Rect(tile))) continue;
        EXPECT_TRUE(std::binary_search(collected[tile].begin(), collected[tile].end(), i))
            << "triangle " << i << " missed by tile " << tile << " at instant " << k;
      }
    }
  }
}

TEST(Bvh, MissesNothingInPerspective) {
  for (unsigned seed = 0; seed < 8; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    ExpectNothingMissed(RandomScene(PerspectiveView(200, 150, 0.9, 0.1, seed % 2 ? 20.0 : 0.0), seed));
  }
}

TEST(Bvh, MissesNothingInOrthographic) {
  for (unsigned seed = 0; seed < 8; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    ExpectNothingMissed(RandomScene(OrthographicView(200, 150, 2, 0.1, 20), seed));
  }
}

TEST(Bvh, MissesNothingThatCrossesTheNearPlane) {
  RandomSceneOptions options;
  options.moving_fraction = 1;
  options.nearest = -0.5;
  options.farthest = 1;
  for (unsigned seed = 100; seed < 108; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    ExpectNothingMissed(RandomScene(PerspectiveView(160, 100, 1.2, 0.3), seed, options));
  }
}

TEST(Bvh, MissesNothingOnCurves) {
  RandomSceneOptions options;
  options.triangles = 150;
  options.curved_fraction = 0.8;
  for (unsigned seed = 200; seed < 212; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    options.nearest = seed % 3 == 0 ? -0.5 : -3;
    options.farthest = seed % 3 == 0 ? 3 : 30;
    ExpectNothingMissed(RandomScene(seed % 4 == 1
                                        ? OrthographicView(200, 150, 2, 0.1, 20)
                                        : PerspectiveView(200, 150, 0.9, 0.1, seed % 2 ? 20.0 : 0.0),
                                    seed, options));
  }
}

TEST(Bvh, TakesStaticTrianglesOnlyWhereTheirBoundsAre) {
  // For what stands still in front of the camera the answer is exact: no superfluous triangle at all.
  const FrameView view = PerspectiveView(256, 192);
  FrameSceneBuilder builder(view);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int i = 0; i < 2000; ++i) {
    const double x = 280 * unit(random) - 12, y = 220 * unit(random) - 14;
    std::array<Corner, 3> corners;
    for (Corner& c : corners) {
      c = {x + 6 * unit(random), y + 6 * unit(random), 1 + 20 * unit(random)};
    }
    builder.AddTriangle(corners);
  }
  const auto frame = builder.Build();
  const auto bvh = MustBuild(frame);
  const TileGrid grid{view.width, view.height};
  for (int tile = 0; tile < grid.Count(); ++tile) {
    std::vector<uint32_t> expected;
    for (uint32_t i = 0; i < frame->triangles.size(); ++i) {
      if (BoundsAt(*frame, frame->triangles[i], 0)->Overlaps(grid.Rect(tile))) expected.push_back(i);
    }
    EXPECT_EQ(Collect(*bvh, grid.Rect(tile)), expected) << "tile " << tile;
  }
}

TEST(Bvh, CollectsFewSuperfluousMovingTriangles) {
  const FrameView view = PerspectiveView(256, 192);
  FrameSceneBuilder builder(view);
  std::mt19937 random(8);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int i = 0; i < 1000; ++i) {
    const double x = 256 * unit(random), y = 192 * unit(random), dx = 30 * unit(random) - 15;
    builder.AddTriangle({{{x, y, 5}, {x + 4, y, 5}, {x, y + 4, 6}}},
                        {{{x + dx, y + 3, 5}, {x + 4 + dx, y + 3, 5}, {x + dx, y + 7, 6}}});
  }
  const auto frame = builder.Build();
  const auto bvh = MustBuild(frame);
  const TileGrid grid{view.width, view.height};
  int collected = 0, needed = 0;
  for (int tile = 0; tile < grid.Count(); ++tile) {
    collected += int(Collect(*bvh, grid.Rect(tile)).size());
    for (const FrameTriangle& triangle : frame->triangles) {
      bool seen = false;
      for (int k = 0; k <= 64 && !seen; ++k) {
        seen = BoundsAt(*frame, triangle, k / 64.0)->Overlaps(grid.Rect(tile));
      }
      needed += seen;
    }
  }
  EXPECT_GE(collected, needed);
  EXPECT_LE(collected, 1.05 * needed);
}

TEST(Bvh, CollectsTheSameAtAnySize) {
  for (const double size : {1e18, 1e-18, 0x1p-40}) {
    SCOPED_TRACE(testing::Message() << "size " << size);
    FrameView view = PerspectiveView(200, 150, 0.9, 0.1, 25);
    const auto frame = RandomScene(view, 3);
    view.znear *= size;
    view.zfar *= size;
    const auto scaled = RandomScene(view, 3, {}, size);
    const auto bvh = MustBuild(frame), scaled_bvh = MustBuild(scaled);
    const TileGrid grid{view.width, view.height};
    for (int tile = 0; tile < grid.Count(); ++tile) {
      EXPECT_EQ(Collect(*bvh, grid.Rect(tile)), Collect(*scaled_bvh, grid.Rect(tile))) << "tile " << tile;
    }
  }
}

TEST(Bvh, DoesNotDependOnThreads) {
  RandomSceneOptions options;
  options.triangles = 3000;
  const auto frame = RandomScene(PerspectiveView(200, 150), 5, options);
  const auto one = MustBuild(frame, 1), four = MustBuild(frame, 4);
  const TileGrid grid{200, 150};
  for (int tile = 0; tile < grid.Count(); ++tile) {
    EXPECT_EQ(Collect(*one, grid.Rect(tile)), Collect(*four, grid.Rect(tile)));
  }
}

TEST(Bvh, TouchingATileAtOneInstantIsHarmless) {
  FrameSceneBuilder builder(PerspectiveView(96, 96));
  // Comes from the right and touches the border x = 32 with one vertex at shutter close.
  builder.AddTriangle({{{40, 40, 2}, {50, 40, 2}, {50, 50, 2}}}, {{{32, 40, 2}, {42, 40, 2}, {42, 50, 2}}});
  // Lies with one edge in the border.
  builder.AddTriangle({{{32, 40, 2}, {32, 50, 2}, {42, 50, 2}}});
  const auto bvh = MustBuild(builder.Build());
  EXPECT_EQ(Collect(*bvh, {32, 32, 32, 32}), (std::vector<uint32_t>{0, 1}));
  EXPECT_LE(Collect(*bvh, {0, 32, 32, 32}).size(), 2u);
  EXPECT_TRUE(Collect(*bvh, {0, 0, 32, 32}).empty());
}

TEST(Bvh, EmptySceneHasNothingVisible) {
  const auto bvh = MustBuild(FrameSceneBuilder(PerspectiveView(64, 64)).Build());
  EXPECT_TRUE(Collect(*bvh, {0, 0, 32, 32}).empty());
}

TEST(Bvh, StackedAndNestedTrianglesBuild) {
  // No split separates equal triangles, and sizes that grow by powers want a tree as deep as there are many.
  FrameSceneBuilder stacked(PerspectiveView(64, 64));
  for (int i = 0; i < 5000; ++i) stacked.AddTriangle({{{1, 1, 2}, {9, 1, 2}, {1, 9, 2}}});
  EXPECT_EQ(Collect(*MustBuild(stacked.Build()), {0, 0, 32, 32}).size(), 5000u);

  FrameSceneBuilder nested(PerspectiveView(64, 64, 0.8, 1e-20));
  for (int i = 0; i < 600; ++i) {
    const double s = std::pow(1.15, i) * 1e-18;
    nested.AddViewTriangle({V3d(s, s, -10 * s), V3d(2 * s, s, -10 * s), V3d(s, 2 * s, -11 * s)});
  }
  const auto frame = nested.Build();
  size_t all = 0;
  all = Collect(*MustBuild(frame), {0, 0, 64, 64}).size();
  EXPECT_EQ(all, 600u);
}

TEST(Bvh, LongMotionReachesFewTilesItDoesNotTouch) {
  // Small triangles that cross the frame askew or on arcs: over the whole shutter the bounds of each are a
  // large part of the frame.
  for (const int degree : {1, 2, 3}) {
    FrameSceneBuilder builder(PerspectiveView(512, 512));
    std::mt19937 random(unsigned(degree) + 40);
    std::uniform_real_distribution<double> unit(0, 1);
    for (int i = 0; i < 100; ++i) {
      const double radius = 100 + 140 * unit(random), start = 2 * M_PI * unit(random);
      std::vector<RasterPoint> points;
      for (const V2d& corner : {V2d(0, 0), V2d(5, 0), V2d(0, 5)}) {
        for (int k = 0; k <= 4 * degree; ++k) {
          const double angle = start + M_PI / 2 * k / (4.0 * degree);
          points.push_back(builder.Raster(Corner{256 + corner.x + radius * std::cos(angle),
                                                 256 + corner.y + radius * std::sin(angle), 5}));
        }
      }
      builder.AddCurvedMesh(points, degree, 4, {{0, 1, 2}});
    }
    const auto frame = builder.Build();
    const auto bvh = MustBuild(frame);
    const TileGrid grid{512, 512};
    int64_t collected = 0, touched = 0, in_hulls = 0;
    for (int tile = 0; tile < grid.Count(); ++tile) {
      const TileRect rect = grid.Rect(tile);
      collected += int64_t(Collect(*bvh, rect).size());
      for (const FrameTriangle& triangle : frame->triangles) {
        RasterBounds hull;
        bool touches = false;
        for (int k = 0; k <= 64; ++k) {
          const RasterBounds now = *BoundsAt(*frame, triangle, k / 64.0);
          touches = touches || now.Overlaps(rect);
          hull = {std::min(hull.x0, now.x0), std::min(hull.y0, now.y0), std::max(hull.x1, now.x1),
                  std::max(hull.y1, now.y1)};
        }
        touched += touches;
        in_hulls += hull.Overlaps(rect);
      }
    }
    EXPECT_LT(double(collected), 1.6 * double(touched));
    EXPECT_GT(double(in_hulls), 2.0 * double(touched));
  }
}

TEST(Bvh, TheAnswerDoesNotDependOnTheBuild) {
  RandomSceneOptions options;
  options.triangles = 3000;
  options.curved_fraction = 0.3;
  const auto frame = RandomScene(PerspectiveView(200, 150), 5, options);
  const auto one = MustBuild(frame, 1), many = MustBuild(frame, 8);
  const TileGrid grid{200, 150};
  for (int tile = 0; tile < grid.Count(); ++tile) {
    EXPECT_EQ(Collect(*one, grid.Rect(tile)), Collect(*many, grid.Rect(tile))) << "tile " << tile;
  }
}

}  // namespace
}  // namespace shutterline::engine
