#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "common/math/tolerance.h"
#include "tests/engine/scene_motion/scene_builder.h"
#include "worker/engine/scene/frame_scene.h"
#include "worker/engine/scene/motion.h"

namespace shutterline::engine::motion_fit_test {
namespace {

using ::testing::IsEmpty;

std::shared_ptr<const FrameScene> MustBuild(const SceneBuilder& b, const RenderSettings& settings) {
  auto built = BuildFrameScene(b.scene, 0, settings);
  EXPECT_TRUE(built.ok()) << built.status().ToString();
  return built.ok() ? *built : nullptr;
}

RenderSettings Settings(std::optional<int> degree = {}, std::optional<int> pieces = {}) {
  RenderSettings settings = SquareSettings();
  settings.width = settings.height = 400;
  settings.motion_degree = degree;
  settings.motion_pieces = pieces;
  return settings;
}

/// The exact places at shutter time t: those at open of a shutter that opens and closes there.
std::shared_ptr<const FrameScene> StillAt(const SceneBuilder& b, RenderSettings settings, double t) {
  settings.shutter_open = settings.shutter_close =
      (1 - t) * settings.shutter_open + t * settings.shutter_close;
  return MustBuild(b, settings);
}

/// The largest distance between motion and path at `count` random times, over vertices in the frame.
double LargestMiss(const SceneBuilder& b, const RenderSettings& settings, const FrameScene& frame, int count,
                   unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  double largest = 0;
  for (int i = 0; i < count; ++i) {
    const double t = unit(random);
    const auto still = StillAt(b, settings, t);
    for (size_t p = 0; p < frame.primitives.size(); ++p) {
      const FramePrimitive& primitive = frame.primitives[p];
      for (uint32_t v = primitive.first_vertex; v < primitive.first_vertex + primitive.vertex_count; ++v) {
        const RasterPoint fit = frame.VertexAt(primitive, v, t);
        const RasterPoint path = still->ControlPoint(still->primitives[p], v, 0);
        if (!IsInFront(fit) || !IsInFront(path)) continue;
        const V2d a = Raster(path), c = Raster(fit);
        if (a.x < 0 || a.x > frame.view.width || a.y < 0 || a.y > frame.view.height) continue;
        largest = std::max(largest, std::hypot(a.x - c.x, a.y - c.y));
      }
    }
  }
  return largest;
}

/// Quaternion keys of a turn by `angle` about z.
std::vector<float> Turn(double angle) {
  return {0, 0, 0, 1, 0, 0, float(std::sin(angle / 2)), float(std::cos(angle / 2))};
}

TEST(MotionFit, KnownPathsGetTheirDegree) {
  struct Known {
    const char* name;
    std::vector<float> times, values;
    Interpolation interpolation;
    int degree, pieces;
  };
  const std::vector<Known> paths = {
      {"line", {0, 1}, {0, 0, 0, 1, 0.5f, 0}, Interpolation::kLinear, 1, 1},
      {"line towards the camera", {0, 1}, {0, 0, 0, 0, 0, 2}, Interpolation::kLinear, 1, 1},
      // x = t, y = 2 t (1 - t): tangents (1, 2) and (1, -2).
      {"parabola",
       {0, 1},
       {0, 0, 0, 0, 0, 0, 1, 2, 0, 1, -2, 0, 1, 0, 0, 0, 0, 0},
       Interpolation::kCubicSpline,
       2,
       1},
      // y = t (1 - t) (1 - 2 t).
      {"cubic",
       {0, 1},
       {0, 0, 0, 0, 0, 0, 1, 1, 0, 1, 1, 0, 1, 0, 0, 0, 0, 0},
       Interpolation::kCubicSpline,
       3,
       1},
      {"there and back", {0, 0.5f, 1}, {0, 0, 0, 1, 0, 0, 0, 0, 0}, Interpolation::kLinear, 1, 2},
      {"a corner at a quarter", {0, 0.25f, 1}, {0, 0, 0, 1, 0, 0, 0, 1, 0}, Interpolation::kLinear, 1, 4},
      {"two parabolas",
       {0, 0.5f, 1},
       {0, 0, 0, 0, 0, 0, 2, 4, 0, 2, -4, 0, 1, 0, 0, 2, 4, 0, 2, -4, 0, 2, 0, 0, 0, 0, 0},
       Interpolation::kCubicSpline,
       2,
       2},
      {"rest", {0, 1}, {1, 0, 0, 1, 0, 0}, Interpolation::kLinear, 0, 1},
      {"out and exactly back", {0, 0.5f, 1}, {1, 0, 0, 0.5f, 0, 0, 1, 0, 0}, Interpolation::kLinear, 1, 2},
  };
  for (const Known& known : paths) {
    SCOPED_TRACE(known.name);
    SceneBuilder b;
    b.AddCamera();
    const int node = b.AddNode(-1, V3d(0), b.AddMesh(Triangle()));
    b.AddChannel(node, AnimatedPath::kTranslation, known.times, known.values, known.interpolation);
    const auto frame = MustBuild(b, Settings());
    EXPECT_EQ(frame->primitives[0].degree, known.degree);
    EXPECT_EQ(frame->primitives[0].pieces, known.pieces);
    EXPECT_EQ(frame->control_points.size(), size_t(3 * (known.degree * known.pieces + 1)));
    EXPECT_THAT(frame->warnings, IsEmpty());
    EXPECT_LT(LargestMiss(b, Settings(), *frame, 50, 1), 1e-4);  // Keys are floats.
  }
}

/// Turning, sliding, growing, on a turning camera or not: whatever glTF's keys can do to a triangle.
SceneBuilder RandomAnimation(std::mt19937& random) {
  std::uniform_real_distribution<float> unit(-1, 1);
  SceneBuilder b;
  const int camera = b.AddCamera();
  for (int i = 0; i < 3; ++i) {
    const int parent = b.AddNode(-1, V3d(unit(random), unit(random), unit(random)));
    MeshPrimitive shape = Triangle();
    for (V3f& p : shape.positions) p += V3f(unit(random), unit(random), unit(random));
    const int node = b.AddNode(parent, V3d(unit(random), unit(random), 0), b.AddMesh(shape));
    for (const int animated : {parent, node, i == 0 && random() % 2 ? camera : node}) {
      std::vector<float> times{-0.1f, 1.1f};
      if (random() % 2) times = {0, 0.5f, 1};
      std::vector<float> values;
      const bool turns = random() % 2;
      for (size_t k = 0; k < times.size(); ++k) {
        if (turns) {
          Quatd q(1, unit(random) * 0.5, unit(random) * 0.5, unit(random));
          q.normalize();
          for (const double c : {q.v.x, q.v.y, q.v.z, q.r}) values.push_back(float(c));
        } else {
          for (int c = 0; c < 3; ++c) values.push_back((animated == camera && c == 2 ? 5 : 0) + unit(random));
        }
      }
      if (animated == camera && turns) continue;  // Its own channels follow.
      b.AddChannel(animated, turns ? AnimatedPath::kRotation : AnimatedPath::kTranslation, times, values);
    }
  }
  if (random() % 2) {
    const float s = 0.1f * unit(random);
    b.AddChannel(camera, AnimatedPath::kRotation, {0, 1}, {0, 0, 0, 1, 0, s, 0, std::sqrt(1 - s * s)});
  }
  return b;
}

TEST(MotionFit, CurvesStayWithinTolerance) {
  std::array<int, 4> by_degree{};
  for (unsigned seed = 0; seed < 60; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937 random(seed);
    const SceneBuilder b = RandomAnimation(random);
    const auto frame = MustBuild(b, Settings());
    for (const FramePrimitive& primitive : frame->primitives) ++by_degree[size_t(primitive.degree)];
    if (!frame->warnings.empty()) continue;  // It says that it does not.
    // The check times are few: in between, the distance may be a little more.
    EXPECT_LE(LargestMiss(b, Settings(), *frame, 40, seed), 1.15 * kPathPixels);
  }
  EXPECT_GT(by_degree[2], 5);
  EXPECT_GT(by_degree[3], 5);
}

TEST(MotionFit, NoLesserMotionWouldDo) {
  for (unsigned seed = 100; seed < 120; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937 random(seed);
    const SceneBuilder b = RandomAnimation(random);
    const auto frame = MustBuild(b, Settings());
    for (size_t p = 0; p < frame->primitives.size(); ++p) {
      const FramePrimitive& chosen = frame->primitives[p];
      for (int pieces = 1; pieces <= chosen.pieces; pieces *= 2) {
        for (int degree = 1; degree <= (pieces < chosen.pieces ? 3 : chosen.degree - 1); ++degree) {
          const auto lesser = MustBuild(b, Settings(degree, pieces));
          const std::string node = "node " + std::to_string(chosen.node) + " ";
          const bool named = std::any_of(lesser->warnings.begin(), lesser->warnings.end(),
                                         [&](const auto& w) { return w.compare(0, node.size(), node) == 0; });
          EXPECT_TRUE(named) << "primitive " << p << " could do with degree " << degree << " in " << pieces;
        }
      }
    }
  }
}

TEST(MotionFit, AQuarterTurnErrsByTheThirdPowerOfItsPieces) {
  // A corner 80 px from the axis, seen along it. Interpolation of degree 2 misses a circle by
  // r θ³ / (72 √3), θ the angle of a piece.
  SceneBuilder b;
  b.AddCamera();
  const int node = b.AddNode(-1, V3d(0), b.AddMesh(Triangle()));
  b.AddChannel(node, AnimatedPath::kRotation, {0, 1}, Turn(M_PI / 2));
  for (const int pieces : {1, 2, 4}) {
    const auto frame = MustBuild(b, Settings(2, pieces));
    const double expected = 80 * std::pow(M_PI / 2 / pieces, 3) / (72 * std::sqrt(3.0));
    EXPECT_NEAR(LargestMiss(b, Settings(), *frame, 300, 3), expected, 0.08 * expected) << pieces;
  }
  const auto frame = MustBuild(b, Settings());
  EXPECT_EQ(frame->primitives[0].degree, 3);
  EXPECT_EQ(frame->primitives[0].pieces, 2);
  EXPECT_NEAR(frame->primitives[0].motion_pixels, 80 * M_PI / 2, 0.5);
}

TEST(MotionFit, JointsHaveNoGapsAndEndsAreExact) {
  for (unsigned seed = 200; seed < 220; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937 random(seed);
    const SceneBuilder b = RandomAnimation(random);
    const auto frame = MustBuild(b, Settings()), open = StillAt(b, Settings(), 0),
               close = StillAt(b, Settings(), 1);
    for (size_t p = 0; p < frame->primitives.size(); ++p) {
      const FramePrimitive& primitive = frame->primitives[p];
      for (uint32_t v = primitive.first_vertex; v < primitive.first_vertex + 3; ++v) {
        EXPECT_EQ(frame->VertexAt(primitive, v, 0), open->ControlPoint(open->primitives[p], v, 0));
        EXPECT_EQ(frame->VertexAt(primitive, v, 1), close->ControlPoint(close->primitives[p], v, 0));
        for (int joint = 1; joint < primitive.pieces; ++joint) {
          const double t = double(joint) / primitive.pieces;
          const RasterPoint at = frame->VertexAt(primitive, v, t);
          EXPECT_EQ(at, frame->ControlPoint(primitive, v, joint * primitive.degree));
          const RasterPoint before = frame->VertexAt(primitive, v, std::nextafter(t, 0));
          EXPECT_NEAR(Raster(before).x, Raster(at).x, 1e-9);
          EXPECT_NEAR(Raster(before).y, Raster(at).y, 1e-9);
        }
      }
    }
  }
}

TEST(MotionFit, ReversedTimeGivesReversedCurves) {
  for (unsigned seed = 300; seed < 320; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937 random(seed);
    const SceneBuilder forth = RandomAnimation(random);
    SceneBuilder back = forth;
    back.scene = std::make_shared<Scene>(*forth.scene);
    for (AnimationChannel& channel : back.scene->animations[0].channels) {
      const size_t keys = channel.times.size(), width = size_t(channel.width);
      const AnimationChannel old = channel;
      for (size_t k = 0; k < keys; ++k) {
        channel.times[k] = 1 - old.times[keys - 1 - k];
        std::copy_n(old.values.begin() + ptrdiff_t((keys - 1 - k) * width), width,
                    channel.values.begin() + ptrdiff_t(k * width));
      }
    }
    const auto a = MustBuild(forth, Settings()), c = MustBuild(back, Settings());
    for (size_t p = 0; p < a->primitives.size(); ++p) {
      const FramePrimitive &one = a->primitives[p], &two = c->primitives[p];
      EXPECT_EQ(one.degree, two.degree);
      EXPECT_EQ(one.pieces, two.pieces);
      if (one.PointsPerVertex() != two.PointsPerVertex()) continue;
      const int last = one.PointsPerVertex() - 1;
      for (uint32_t v = one.first_vertex; v < one.first_vertex + one.vertex_count; ++v) {
        for (int i = 0; i <= last; ++i) {
          EXPECT_NEAR(a->ControlPoint(one, v, i).x, c->ControlPoint(two, v, last - i).x, 1e-3);
          EXPECT_NEAR(a->ControlPoint(one, v, i).w, c->ControlPoint(two, v, last - i).w, 1e-5);
        }
      }
    }
  }
}

TEST(MotionFit, PrimitivesOfAMeshShareTheirCurves) {
  // One small and one large triangle with a common edge: the small one alone would need less.
  SceneBuilder b;
  b.AddCamera();
  MeshPrimitive small, large;
  small.positions = {{0, 0, 0}, {0.1f, 0, 0}, {0, 0.1f, 0}};
  large.positions = {{0.1f, 0, 0}, {0, 0.1f, 0}, {1.5f, 1.5f, 0}};
  small.triangles = large.triangles = {{0, 1, 2}};
  const int mesh = b.AddMesh(small);
  const int alone = b.AddMesh(small);
  b.scene->meshes[size_t(mesh)].primitives.push_back(large);
  for (const int m : {mesh, alone}) {
    const int node = b.AddNode(-1, V3d(0), m);
    b.AddChannel(node, AnimatedPath::kRotation, {0, 1}, Turn(1.2));
  }
  const auto frame = MustBuild(b, Settings());
  const FramePrimitive &one = frame->primitives[0], &two = frame->primitives[1];
  EXPECT_EQ(one.degree, two.degree);
  EXPECT_EQ(one.pieces, two.pieces);
  for (int i = 0; i < one.PointsPerVertex(); ++i) {
    EXPECT_EQ(frame->ControlPoint(one, one.first_vertex + 1, i),
              frame->ControlPoint(two, two.first_vertex, i));
    EXPECT_EQ(frame->ControlPoint(one, one.first_vertex + 2, i),
              frame->ControlPoint(two, two.first_vertex + 1, i));
  }
  EXPECT_LT(frame->primitives[2].PointsPerVertex(), one.PointsPerVertex());
}

TEST(MotionFit, AJumpIsSweptInOnePieceAndNamed) {
  SceneBuilder b;
  b.AddCamera();
  const int node = b.AddNode(-1, V3d(0), b.AddMesh(Triangle()));
  b.AddChannel(node, AnimatedPath::kTranslation, {0, 0.3f}, {0, 0, 0, 1, 0, 0}, Interpolation::kStep);
  const auto frame = MustBuild(b, Settings());
  EXPECT_EQ(frame->primitives[0].pieces, kMaxMotionPieces);
  EXPECT_EQ(frame->primitives[0].degree, 1) << "higher degrees swing about a jump";
  EXPECT_EQ(frame->warnings.size(), 1u);
  for (const double t : {0.0, 0.2, 0.29, 0.33, 0.7, 1.0}) {
    EXPECT_NEAR(Raster(frame->VertexAt(frame->primitives[0], 0, t)).x, t < 0.3 ? 200 : 280, 1e-9) << t;
  }
}

TEST(MotionFit, LinearPiecesFollowTheCurve) {
  for (unsigned seed = 400; seed < 430; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(0, 1);
    const auto frame = MustBuild(RandomAnimation(random), Settings());
    for (const FramePrimitive& primitive : frame->primitives) {
      const int pieces = primitive.linear_pieces;
      ASSERT_GE(pieces, primitive.pieces);
      if (primitive.degree < 2 || pieces == kMaxLinearPieces) continue;
      for (int i = 0; i < 200; ++i) {
        const double t = unit(random);
        const int piece = std::min(int(t * pieces), pieces - 1);
        for (uint32_t v = primitive.first_vertex; v < primitive.first_vertex + 3; ++v) {
          const RasterPoint curve = frame->VertexAt(primitive, v, t);
          const RasterPoint a = frame->VertexAt(primitive, v, double(piece) / pieces),
                            c = frame->VertexAt(primitive, v, double(piece + 1) / pieces);
          const double u = t * pieces - piece;
          EXPECT_LE(PathErrorBetween(frame->view, curve, (1 - u) * a + u * c).pixels, kChordPixels);
        }
      }
    }
  }
}

}  // namespace
}  // namespace shutterline::engine::motion_fit_test
