#include "worker/engine/reference/embree_tracer.h"

#include <algorithm>
#include <numbers>
#include <random>

#include "tests/engine/reference/reference_test_util.h"
#include "tests/support/point_oracle.h"

namespace shutterline::engine {
namespace {

/// Triangles of all sizes, static and moving, some single-sided, some through the near plane.
FrameSceneBuilder RandomBuilder(const FrameView& view, unsigned seed, int count = 60, double size = 1) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  const auto symmetric = [&] { return 2 * unit(random) - 1; };
  FrameSceneBuilder builder(view);
  for (int i = 0; i < count; ++i) {
    const double distance = 10 * unit(random) - 0.5, spread = view.perspective ? 0.4 * distance + 0.3 : 1.2;
    const V3d centre(spread * symmetric(), spread * symmetric(), -distance);
    const double radius = std::pow(10.0, -1.3 + 1.6 * unit(random));
    const V3d shift = unit(random) * V3d(symmetric(), symmetric(), symmetric());
    std::array<V3d, 3> open, close;
    for (int k = 0; k < 3; ++k) {
      open[k] = size * (centre + radius * V3d(symmetric(), symmetric(), symmetric()));
      close[k] = open[k] + size * (shift + 0.3 * radius * V3d(symmetric(), symmetric(), symmetric()));
    }
    const FlatLook look{V3f(float(unit(random)), float(unit(random)), float(unit(random))),
                        unit(random) < 0.5};
    if (unit(random) < 0.7) {
      builder.AddViewTriangle(open, close, look);
    } else {
      builder.AddViewTriangle(open, look);
    }
  }
  return builder;
}

/// The tracer's picture by another way: the oracle at the very same points.
Image OracleImage(const FrameScene& frame, int spp, uint64_t seed, int number) {
  Image image(frame.view.width, frame.view.height);
  const PointPattern pattern(seed, number);
  for (int y = 0; y < frame.view.height; ++y) {
    for (int x = 0; x < frame.view.width; ++x) {
      V4d sum(0);
      for (int i = 0; i < spp; ++i) {
        const PixelPoint p = pattern.Pixel(x, y).At(uint32_t(i));
        const auto seen = SeeAt(frame, x + p.x, y + p.y, p.t);
        if (!seen) continue;
        const FramePrimitive& primitive = frame.primitives[frame.triangles[seen->triangle].primitive];
        V4d color(primitive.material->base_color_factor);
        if (!primitive.source->colors.empty()) {
          const auto& corner = primitive.source->triangles[seen->triangle - primitive.first_triangle];
          const auto& colors = primitive.source->colors;
          const V4d c = (1 - seen->b1 - seen->b2) * V4d(colors[corner[0]]) +
                        seen->b1 * V4d(colors[corner[1]]) + seen->b2 * V4d(colors[corner[2]]);
          color = color * c;
        }
        color.w = 1;
        sum += color;
      }
      for (int c = 0; c < 4; ++c) image.At(x, y)[c] = float(sum[c] / spp);
    }
  }
  return image;
}

/// Pixels that differ by more than rounding.
int CountDifferent(const Image& a, const Image& b, double tolerance = 1e-5) {
  int different = 0;
  for (int y = 0; y < a.height(); ++y) {
    for (int x = 0; x < a.width(); ++x) {
      double largest = 0;
      for (int c = 0; c < 4; ++c)
        largest = std::max(largest, std::abs(double(a.At(x, y)[c]) - b.At(x, y)[c]));
      different += largest > tolerance;
    }
  }
  return different;
}

TEST(EmbreeTracer, SeesWhatTheOracleSees) {
  // A ray that passes an edge within single precision may go either way: a pixel in a thousand, not more.
  int different = 0, pixels = 0;
  for (unsigned seed = 0; seed < 10; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    const FrameView view =
        seed % 2 ? OrthographicView(40, 30, 1, 0.2, 9) : PerspectiveView(40, 30, 0.8, 0.2, seed % 4 ? 8 : 0);
    const auto frame = RandomBuilder(view, seed).Build();
    const Image seen = OracleImage(*frame, 20, seed, 4);
    const Image traced = RenderTiles(*MakeTracer(frame, 20, seed, 4), 40, 30);
    const int here = CountDifferent(seen, traced);
    EXPECT_LE(here, 6);
    different += here;
    pixels += 40 * 30;
  }
  EXPECT_LE(different, pixels / 1000);
}

TEST(EmbreeTracer, NearPlaneInMidShutterAgreesWithTheOracle) {
  // Hard case 13: one vertex passes from in front of the eye to behind it.
  const FrameView view = PerspectiveView(24, 24, 0.8, 0.2);
  FrameSceneBuilder builder(view);
  builder.AddRasterTriangle({{{2, 3, 0.2, 1}, {20, 4, 0.2, 1}, {9, 22, 0.2, 1}}},
                            {{{2, 3, 0.2, 1}, {20, 4, 0.2, 1}, {9, 22, 0.2, -1}}});
  const auto frame = builder.Build();
  const Image traced = RenderTiles(*MakeTracer(frame, 64), 24, 24);
  for (const float value : traced.values()) EXPECT_TRUE(std::isfinite(value));
  EXPECT_LE(CountDifferent(OracleImage(*frame, 64, 0, 0), traced), 1);
}

TEST(EmbreeTracer, ShadesAtTheHit) {
  // Vertex colours vary over triangles in perspective: shading must be that of the point that was hit.
  FrameSceneBuilder builder(PerspectiveView(32, 32));
  FlatLook look{V3f(0.8f, 0.6f, 0.4f), true, {{1, 0, 0, 1}, {0, 1, 0, 1}, {0, 0, 1, 1}}};
  builder.AddTriangle({{{-3, -5, 1}, {40, 3, 6}, {5, 45, 3}}}, {{{-9, -5, 2}, {33, 8, 4}, {9, 40, 3}}}, look);
  builder.AddRectangle(3, 3, 9, 9, 0.5, {V3f(1, 1, 1)}, 8, 3);
  const auto frame = builder.Build();
  ASSERT_FALSE(frame->primitives[0].uniform_colors);
  EXPECT_LE(CountDifferent(OracleImage(*frame, 24, 3, 1), RenderTiles(*MakeTracer(frame, 24, 3, 1), 32, 32)),
            2);
}

TEST(EmbreeTracer, EverySizeGivesTheSamePicture) {
  const auto picture = [](double size) {
    const FrameView view = PerspectiveView(40, 30, 0.8, 0.2 * size, 8 * size);
    return RenderTiles(*MakeTracer(RandomBuilder(view, 5, 60, size).Build(), 32), 40, 30);
  };
  const Image usual = picture(1);
  EXPECT_LE(CountDifferent(usual, picture(1e18)), 5);
  EXPECT_LE(CountDifferent(usual, picture(1e-18)), 5);
  EXPECT_EQ(usual.values(), picture(0x1p60).values()) << "a power of two rounds nothing";
  EXPECT_EQ(usual.values(), picture(0x1p-60).values());
}

TEST(EmbreeTracer, FurnaceIsExactlyOne) {
  // The inside of a closed sphere of shared vertices which turns and breathes: no ray may slip through.
  constexpr int kRings = 24, kSegments = 36;
  std::vector<V3d> open, close;
  std::vector<std::array<uint32_t, 3>> triangles;
  for (int r = 0; r <= kRings; ++r) {
    for (int s = 0; s < kSegments; ++s) {
      const double theta = std::numbers::pi * r / kRings, phi = 2 * std::numbers::pi * s / kSegments;
      const V3d p(std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi));
      open.push_back(3.0 * p);
      close.push_back(V3d(3.3 * p.x + 0.4 * p.z, 3.5 * p.y - 0.2, 3.1 * p.z - 0.4 * p.x));
      if (r == kRings) continue;
      const auto at = [&](int ring, int segment) { return uint32_t(ring * kSegments + segment % kSegments); };
      triangles.push_back({at(r, s), at(r + 1, s), at(r + 1, s + 1)});
      triangles.push_back({at(r, s), at(r + 1, s + 1), at(r, s + 1)});
    }
  }
  for (const bool moving : {true, false}) {
    FrameSceneBuilder builder(PerspectiveView(64, 48, 1.4));
    builder.AddViewMesh(open, moving ? close : std::vector<V3d>{}, triangles);
    const Image image = RenderTiles(*MakeTracer(builder.Build(), 100), 64, 48);
    for (const float value : image.values()) ASSERT_EQ(value, 1.0f);
  }
}

TEST(EmbreeTracer, OfCoplanarDuplicatesTheLowestIsSeen) {
  const FrameView view = PerspectiveView(48, 48);
  for (const bool moving : {false, true}) {
    std::mt19937 random(11);
    std::uniform_real_distribution<double> unit(0, 1);
    std::vector<std::array<Corner, 3>> shapes, targets;
    for (int i = 0; i < 80; ++i) {
      std::array<Corner, 3> open;
      for (Corner& c : open) c = {60 * unit(random) - 6, 60 * unit(random) - 6, 2 + 5 * unit(random)};
      shapes.push_back(open);
      for (Corner& c : open) c.x += moving ? 5 * unit(random) : 0;
      targets.push_back(open);
    }
    FrameSceneBuilder builder(view);
    const auto add_all = [&](const FlatLook& look) {
      std::vector<size_t> order(shapes.size());
      for (size_t i = 0; i < order.size(); ++i) order[i] = i;
      std::shuffle(order.begin(), order.end(), random);
      for (const size_t i : order) {
        if (moving) {
          builder.AddTriangle(shapes[i], targets[i], look);
        } else {
          builder.AddTriangle(shapes[i], look);
        }
      }
    };
    add_all({V3f(1, 0, 0)});
    for (int copy = 0; copy < 3; ++copy) add_all({V3f(0, 1, 0)});
    const Image image = RenderTiles(*MakeTracer(builder.Build(), 32), 48, 48);
    double covered = 0;
    for (int y = 0; y < 48; ++y) {
      for (int x = 0; x < 48; ++x) {
        EXPECT_EQ(image.At(x, y)[1], 0);
        EXPECT_EQ(image.At(x, y)[0], image.At(x, y)[3]);
        covered += image.At(x, y)[3];
      }
    }
    EXPECT_GT(covered, 48 * 48 / 2.0);
  }
}

TEST(EmbreeTracer, TilesAndThreadsDoNotMatter) {
  const auto frame = RandomBuilder(PerspectiveView(70, 45, 0.8, 0.2), 9, 150).Build();
  for (const int spp : {1, 23, 64}) {
    const Image whole = RenderTiles(*MakeTracer(frame, spp), 70, 45, 70, 45);
    const auto tracer = MakeTracer(frame, spp, 0, 0, 2);
    EXPECT_EQ(whole.values(), RenderTiles(*tracer, 70, 45, 32, 32, 1).values());
    EXPECT_EQ(whole.values(), RenderTiles(*tracer, 70, 45, 7, 5, 3).values());
    EXPECT_EQ(whole.values(), RenderTiles(*tracer, 70, 45, 1, 1, 2).values());
  }
}

TEST(EmbreeTracer, SeedsAndFramesAreIndependentEstimates) {
  const int width = 64, height = 64, spp = 16;
  const auto frame = RandomBuilder(PerspectiveView(width, height, 0.8, 0.2), 21, 40).Build();
  const Image truth = RenderTiles(*MakeTracer(frame, 512, 999), width, height);
  const auto error = [&](uint64_t seed, int number) {
    Image image = RenderTiles(*MakeTracer(frame, spp, seed, number), width, height);
    for (size_t i = 0; i < image.values().size(); ++i) image.values()[i] -= truth.values()[i];
    return image;
  };
  const auto correlation = [&](const Image& a, const Image& b) {
    double aa = 0, bb = 0, ab = 0;
    for (size_t i = 0; i < a.values().size(); ++i) {
      aa += double(a.values()[i]) * a.values()[i];
      bb += double(b.values()[i]) * b.values()[i];
      ab += double(a.values()[i]) * b.values()[i];
    }
    return ab / std::sqrt(aa * bb);
  };
  const Image base = error(1, 0);
  EXPECT_EQ(base.values(), error(1, 0).values());
  EXPECT_NEAR(correlation(base, error(2, 0)), 0, 0.08);
  EXPECT_NEAR(correlation(base, error(1, 1)), 0, 0.08);
}

TEST(EmbreeTracer, EmptySceneIsTransparentBlack) {
  const auto frame = FrameSceneBuilder(PerspectiveView(40, 40)).Build();
  const auto tracer = MakeTracer(frame, 7);
  RenderStats stats;
  const Image image = RenderRect(*tracer, {5, 6, 30, 20}, &stats);
  for (const float value : image.values()) EXPECT_EQ(value, 0);
  EXPECT_EQ(stats.instants, 30 * 20 * 7);
  EXPECT_EQ(stats.tiles, 1);
}

TEST(EmbreeTracer, DegenerateTrianglesAreInvisible) {
  FrameSceneBuilder builder(PerspectiveView(32, 32));
  builder.AddTriangle({{{2, 2, 1}, {30, 30, 1}, {16, 16, 1}}});
  builder.AddTriangle({{{2, 2, 1}, {2, 2, 1}, {30, 9, 1}}});
  builder.AddTriangle({{{9, 9, 1}, {9, 9, 1}, {9, 9, 1}}}, {{{9, 29, 1}, {9, 29, 1}, {9, 29, 1}}});
  const Image image = RenderTiles(*MakeTracer(builder.Build(), 64), 32, 32);
  for (const float value : image.values()) EXPECT_EQ(value, 0);
}

}  // namespace
}  // namespace shutterline::engine
