#include "worker/engine/accel/triangle_refs.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "common/job/tile.h"
#include "tests/support/frame_scene_builder.h"

namespace shutterline::engine {
namespace {

/// Strips whose triangles share vertices, that stand still, creep and fly, on curves of every degree; some
/// cross the near plane.
std::shared_ptr<const FrameScene> RandomStrips(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  FrameSceneBuilder builder(PerspectiveView(512, 384));
  for (int strip = 0; strip < 24; ++strip) {
    const int degree = 1 + int(random() % 3), pieces = 1 << random() % 3, count = 40;
    const double speed = std::pow(10.0, 3 * unit(random) - 2), distance = 0.2 + 10 * unit(random);
    const V3d way = speed * V3d(unit(random) - 0.5, unit(random) - 0.5, 0.2 * unit(random) - 0.1);
    std::vector<RasterPoint> points;
    std::vector<std::array<uint32_t, 3>> triangles;
    for (int v = 0; v < count; ++v) {
      const V3d start(0.05 * v - 1, 0.1 * (v % 2), -distance);
      for (int i = 0; i <= degree * pieces; ++i) {
        const double t = double(i) / (degree * pieces);
        points.push_back(builder.Raster(start + t * way + V3d(0, 0.3 * speed * t * (1 - t), 0)));
      }
      if (v >= 2) triangles.push_back({uint32_t(v - 2), uint32_t(v - 1), uint32_t(v)});
    }
    builder.AddCurvedMesh(points, degree, pieces, triangles);
  }
  return builder.Build();
}

TEST(TriangleRefs, TogetherAreWhatEachIsAlone) {
  int cut = 0, whole = 0;
  for (unsigned seed = 0; seed < 6; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    const auto frame = RandomStrips(seed);
    const BoundedRefs made = MakeBoundedRefs(*frame, 0.25);
    ASSERT_EQ(made.refs.size(), made.bounds.size());
    size_t next = 0;
    for (uint32_t i = 0; i < frame->triangles.size(); ++i) {
      const int spans = SpansFor(*frame, i);
      (spans > 1 ? cut : whole) += 1;
      for (int span = 0; span < spans; ++span, ++next) {
        ASSERT_LT(next, made.refs.size());
        EXPECT_EQ(made.refs[next].triangle, i);
        EXPECT_EQ(made.refs[next].span, span);
        EXPECT_EQ(made.refs[next].spans, spans);
        const ViewBounds alone = BoundsOf(*frame, made.refs[next], 0.25);
        EXPECT_EQ(made.bounds[next].lower, alone.lower);
        EXPECT_EQ(made.bounds[next].upper, alone.upper);
      }
    }
    EXPECT_EQ(next, made.refs.size());
  }
  EXPECT_GT(cut, 100);
  EXPECT_GT(whole, 100);
}

/// The plain way: boxes of the places at equal steps, joined span by span.
int SpansByPlaces(const FrameScene& frame, uint32_t triangle) {
  const FrameTriangle& corners = frame.triangles[triangle];
  const FramePrimitive& primitive = frame.primitives[corners.primitive];
  if (primitive.motion_pixels < 2 * kTileSize) return 1;
  const auto area = [&](int spans) {
    double sum = 0;
    for (int span = 0; span < spans; ++span) {
      double x0 = INFINITY, y0 = INFINITY, x1 = -INFINITY, y1 = -INFINITY;
      for (int i = span * kMaxRefSpans / spans; i <= (span + 1) * kMaxRefSpans / spans; ++i) {
        for (const uint32_t vertex : corners.vertices) {
          const RasterPoint p = frame.VertexAt(primitive, vertex, double(i) / kMaxRefSpans);
          if (!(p.w > 0 && p.z <= p.w)) return -1.0;
          x0 = std::min(x0, p.x / p.w), x1 = std::max(x1, p.x / p.w);
          y0 = std::min(y0, p.y / p.w), y1 = std::max(y1, p.y / p.w);
        }
      }
      sum += (x1 - x0 + kTileSize / 2.0) * (y1 - y0 + kTileSize / 2.0);
    }
    return sum;
  };
  double least = area(1), price = 1;
  if (least < 0) return 1;
  int best = 1;
  for (int spans = 2; spans <= kMaxRefSpans; spans *= 2) {
    price /= 0.9;
    if (price * area(spans) >= least) continue;
    least = price * area(spans);
    best = spans;
  }
  return best;
}

TEST(TriangleRefs, SpansAreThoseOfThePlainWay) {
  for (unsigned seed = 10; seed < 14; ++seed) {
    const auto frame = RandomStrips(seed);
    for (uint32_t i = 0; i < frame->triangles.size(); ++i) {
      EXPECT_EQ(SpansFor(*frame, i), SpansByPlaces(*frame, i)) << "triangle " << i << ", seed " << seed;
    }
  }
}

}  // namespace
}  // namespace shutterline::engine
