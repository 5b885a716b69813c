#include <gtest/gtest.h>

#include <random>

#include "tests/engine/scene_motion/scene_builder.h"
#include "tests/stability/hard_case.h"
#include "tests/support/rounds.h"

namespace shutterline::engine::hard_case::curved_motion_test {
namespace {

constexpr PatternKind kPatterns[] = {PatternKind::k2h2v, PatternKind::kRgls};

using CurvedMotion = EachResolver;
INSTANTIATE_TEST_SUITE_P(Resolvers, CurvedMotion, testing::Values(ResolverKind::kSlice, ResolverKind::kPaper),
                         ResolverName);

/// Coverage of the pixel (0, 0) by the last primitive of a frame.
double LastCoverage(const FrameScene& frame, const RenderSettings& settings) {
  const ResolvedTile resolved(frame, TileRect{0, 0, 32, 32}, settings);
  const FramePrimitive& last = frame.primitives.back();
  double sum = 0;
  for (uint32_t i = 0; i < last.triangle_count; ++i) sum += resolved.Coverage(0, 0, last.first_triangle + i);
  EXPECT_LE(resolved.Coverage(0, 0), 1.0);
  return sum;
}

/// A quad whose corners have these control points, over a still one that covers the pixel at depth 3/4 (or
/// outside of it).
std::shared_ptr<const FrameScene> Frame(const std::array<std::vector<RasterPoint>, 4>& corners, int degree,
                                        int pieces, bool covered) {
  FrameSceneBuilder builder(OrthographicView(32, 32));
  const double at = covered ? 0 : 20;
  builder.AddMesh({At(at - 1, at - 1, 0.75), At(at - 1, at + 2, 0.75), At(at + 2, at + 2, 0.75),
                   At(at + 2, at - 1, 0.75)},
                  {}, {{0, 1, 2}, {0, 2, 3}});
  std::vector<RasterPoint> points;
  for (const auto& corner : corners) points.insert(points.end(), corner.begin(), corner.end());
  builder.AddCurvedMesh(points, degree, pieces, {{0, 1, 2}, {0, 2, 3}});
  return builder.Build();
}

TEST_P(CurvedMotion, Row17QuadraticMotionInOneShutter) {
  // Depth 1 − (2t − 1)² against ¾: nearer for half of the shutter. Its middle control point has depth 2,
  // beyond the near plane, where the surface never is.
  const auto corner = [](double x, double y) -> std::vector<RasterPoint> {
    return {At(x, y, 0), At(x, y, 2), At(x, y, 0)};
  };
  const auto frame = Frame({corner(-1, -1), corner(-1, 2), corner(2, 2), corner(2, -1)}, 2, 1, true);
  for (const PatternKind pattern : kPatterns) {
    for (const int n : {16, 256, 4096})
      EXPECT_NEAR(LastCoverage(*frame, With(pattern, n)), 0.5, 2.0 / n) << n;
  }
}

TEST_P(CurvedMotion, Row30ThreeKeysInOneShutter) {
  // X = 1 − |2t − 1|, the right edge of a region: two straight pieces that meet at the key.
  const std::vector<RasterPoint> low_left(3, At(-5, -50)), high_left(3, At(-5, 50));
  const auto frame =
      Frame({low_left, high_left, {At(0, 50), At(1, 50), At(0, 50)}, {At(0, -50), At(1, -50), At(0, -50)}}, 1,
            2, false);
  for (const PatternKind pattern : kPatterns) {
    for (const int n : {16, 256, 4096})
      EXPECT_NEAR(LastCoverage(*frame, With(pattern, n)), 0.5, 1.0 / n) << n;
  }
}

/// Rows 17 and 30 as a file would have them: keys on a node, an orthographic camera of 2 pixels a metre.
std::shared_ptr<const FrameScene> Imported(std::vector<float> times, std::vector<float> x_and_z,
                                           Interpolation interpolation, bool covered) {
  SceneBuilder b;
  b.AddCamera(-1, V3d(0));
  Camera& camera = b.scene->cameras[0];
  camera.perspective = false;
  camera.xmag = camera.ymag = 8;
  camera.znear = 0;
  camera.zfar = 4;
  MeshPrimitive square;
  square.positions = {{-9, 7, 0}, {-8, 7, 0}, {-8, 9, 0}, {-9, 9, 0}};  // Its right edge is the pixel's left.
  square.triangles = {{0, 1, 2}, {0, 2, 3}};
  b.scene->materials[0].double_sided = b.scene->materials[0].unlit = true;
  b.AddNode(-1, V3d(covered ? 0.75 : 5, 0, -1), b.AddMesh(square));  // Depth 3/4.
  const int node = b.AddNode(-1, V3d(0), b.AddMesh(square));
  std::vector<float> values;
  for (size_t i = 0; i < x_and_z.size(); i += 2) {
    values.insert(values.end(), {x_and_z[i], 0, x_and_z[i + 1]});
  }
  b.AddChannel(node, AnimatedPath::kTranslation, std::move(times), std::move(values), interpolation);
  RenderSettings settings = SquareSettings();
  settings.width = settings.height = 32;
  auto frame = BuildFrameScene(b.scene, 0, settings);
  EXPECT_TRUE(frame.ok()) << frame.status();
  EXPECT_TRUE((*frame)->warnings.empty());
  return *frame;
}

TEST_P(CurvedMotion, Row17FromKeys) {
  // z = −4 (2t − 1)²: value −4 and slope ±16 at the ends; depth 1 − (2t − 1)².
  const auto frame =
      Imported({0, 1}, {0, 0, 0.75f, -4, 0, 16, 0, -16, 0.75f, -4, 0, 0}, Interpolation::kCubicSpline, true);
  EXPECT_EQ(frame->primitives[1].degree, 2);
  EXPECT_EQ(frame->primitives[1].pieces, 1);
  for (const PatternKind pattern : kPatterns)
    EXPECT_NEAR(LastCoverage(*frame, With(pattern, 4096)), 0.5, 1e-3);
}

TEST_P(CurvedMotion, Row30FromKeys) {
  // Half a metre is a pixel.
  const auto frame = Imported({0, 0.5f, 1}, {0, -1, 0.5f, -1, 0, -1}, Interpolation::kLinear, false);
  EXPECT_EQ(frame->primitives[1].degree, 1);
  EXPECT_EQ(frame->primitives[1].pieces, 2);
  for (const PatternKind pattern : kPatterns)
    EXPECT_NEAR(LastCoverage(*frame, With(pattern, 4096)), 0.5, 1e-3);
}

TEST_P(CurvedMotion, ClosedMeshesOnCurvesCoverExactly) {
  // A square cut into a fan of triangles about an inner vertex, all on random curves, whose border stands
  // still and holds the pixel: whatever the inside does, the weights add up to one, to the last bit.
  for (unsigned seed = 0; seed < unsigned(Rounds(64)); ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(-1, 1);
    const int degree = 1 + int(seed % 3), pieces = 1 << seed % 4;
    std::vector<RasterPoint> points;
    const auto add = [&](double x, double y, double reach) {
      for (int i = 0; i <= degree * pieces; ++i) {
        const double w = reach > 0 ? 1 + 0.3 * unit(random) : 1;
        points.push_back(w * At(x + reach * unit(random), y + reach * unit(random), 0.5));
      }
    };
    add(-8, -8, 0), add(24, -8, 0), add(24, 24, 0), add(-8, 24, 0), add(7, 9, 8);
    FrameSceneBuilder builder(OrthographicView(32, 32));
    builder.AddCurvedMesh(points, degree, pieces, {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}});
    const ResolvedTile resolved(*builder.Build(), TileRect{0, 0, 16, 16}, With(kPatterns[seed % 2], 16));
    for (int y = 0; y < 16; ++y) {
      for (int x = 0; x < 16; ++x) ASSERT_EQ(resolved.Covered(x, y), resolved.total()) << x << ", " << y;
    }
  }
}

}  // namespace
}  // namespace shutterline::engine::hard_case::curved_motion_test
