#include "worker/engine/scene/frame_scene.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include "tests/engine/scene_motion/scene_builder.h"

namespace shutterline::engine::frame_scene_test {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::shared_ptr<const FrameScene> MustBuild(const SceneBuilder& builder,
                                            const RenderSettings& settings = SquareSettings(),
                                            int frame = 0) {
  auto built = BuildFrameScene(builder.scene, frame, settings);
  EXPECT_TRUE(built.ok()) << built.status().ToString();
  return built.ok() ? *built : nullptr;
}

TEST(FrameScene, StaticTriangleProjectsByHand) {
  SceneBuilder b;
  b.AddCamera();
  b.AddNode(-1, V3d(0), b.AddMesh(Triangle()));
  const auto frame = MustBuild(b);
  ASSERT_EQ(frame->primitives.size(), 1u);
  const FramePrimitive& p = frame->primitives[0];
  EXPECT_EQ(p.degree, 0);
  EXPECT_EQ(p.motion_pixels, 0);
  ASSERT_EQ(frame->control_points.size(), 3u);
  // The focal length is 100 px and the triangle 5 m away: a metre is 20 px.
  const V2d expected[3] = {{50, 50}, {70, 50}, {50, 30}};
  for (uint32_t v = 0; v < 3; ++v) {
    const RasterPoint& c = frame->ControlPoint(p, v, 0);
    EXPECT_NEAR(Raster(c).x, expected[v].x, 1e-12);
    EXPECT_NEAR(Raster(c).y, expected[v].y, 1e-12);
    EXPECT_EQ(c.w, 5);
    EXPECT_EQ(c.z, 0.1);
  }
  EXPECT_THAT(frame->warnings, IsEmpty());
}

TEST(FrameScene, FrameNumberShutterAndFpsGiveSeconds) {
  SceneBuilder b;
  b.AddCamera();
  const int node = b.AddNode(-1, V3d(0), b.AddMesh(Triangle()));
  b.AddChannel(node, AnimatedPath::kTranslation, {0, 10}, {0, 0, 0, 10, 0, 0});
  RenderSettings s = SquareSettings();
  s.fps = 4;
  s.shutter_open = -0.5;
  s.shutter_close = 0.25;
  const auto frame = MustBuild(b, s, 3);
  const FramePrimitive& p = frame->primitives[0];
  ASSERT_EQ(p.degree, 1);
  // Open at 2.5 / 4 s, close at 3.25 / 4 s; one metre a second, 20 px a metre.
  EXPECT_NEAR(Raster(frame->ControlPoint(p, 0, 0)).x, 50 + 20 * 0.625, 1e-9);
  EXPECT_NEAR(Raster(frame->ControlPoint(p, 0, 1)).x, 50 + 20 * 0.8125, 1e-9);
  EXPECT_NEAR(p.motion_pixels, 20 * 0.1875, 1e-9);
  EXPECT_THAT(frame->warnings, IsEmpty());
}

TEST(FrameScene, OnlyWhatMovesHasDegreeOne) {
  SceneBuilder b;
  b.AddCamera();
  const int mesh = b.AddMesh(Triangle());
  const int parent = b.AddNode();
  b.AddNode(parent, V3d(0), mesh);
  b.AddNode(-1, V3d(1, 0, 0), mesh);
  b.AddChannel(parent, AnimatedPath::kTranslation, {0, 1}, {0, 0, 0, 1, 0, 0});
  const auto frame = MustBuild(b);
  ASSERT_EQ(frame->primitives.size(), 2u);
  EXPECT_EQ(frame->primitives[0].degree, 1);
  EXPECT_EQ(frame->primitives[1].degree, 0);
  EXPECT_EQ(frame->control_points.size(), 6u + 3u);
  // After the last key nothing moves any more.
  EXPECT_EQ(MustBuild(b, SquareSettings(), 7)->primitives[0].degree, 0);
  // A still has no motion either.
  RenderSettings still = SquareSettings();
  still.shutter_close = 0;
  EXPECT_EQ(MustBuild(b, still)->primitives[0].degree, 0);
}

TEST(FrameScene, CameraAndObjectMotionCancel) {
  SceneBuilder b;
  const int rig = b.AddNode();
  b.AddCamera(rig);
  b.AddNode(rig, V3d(0.3, 0.2, -1), b.AddMesh(Triangle()));
  const auto s = float(std::sqrt(0.5));
  b.AddChannel(rig, AnimatedPath::kTranslation, {0, 1}, {0, 0, 0, 100, -30, 7});
  b.AddChannel(rig, AnimatedPath::kRotation, {0, 1}, {0, 0, 0, 1, 0, s, 0, s});
  const auto frame = MustBuild(b);
  EXPECT_LT(frame->primitives[0].motion_pixels, 1e-9);
  EXPECT_THAT(frame->warnings, IsEmpty());
}

TEST(FrameScene, MovingCameraMovesTheWorldTheOtherWay) {
  SceneBuilder b;
  const int camera = b.AddCamera();
  b.AddNode(-1, V3d(0), b.AddMesh(Triangle()));
  b.AddChannel(camera, AnimatedPath::kTranslation, {0, 1}, {0, 0, 5, 1, 0, 5});
  const auto frame = MustBuild(b);
  EXPECT_NEAR(Raster(frame->ControlPoint(frame->primitives[0], 0, 1)).x, 30, 1e-9);
  EXPECT_NEAR(frame->primitives[0].motion_pixels, 20, 1e-9);
}

double SignedArea(const FrameScene& frame, uint32_t triangle) {
  const FrameTriangle& t = frame.triangles[triangle];
  const FramePrimitive& p = frame.primitives[t.primitive];
  V2d c[3];
  for (size_t k = 0; k < 3; ++k) c[k] = Raster(frame.ControlPoint(p, t.vertices[k], 0));
  // Positive where counter-clockwise with y up, that is clockwise in the raster's own axes.
  return -0.5 * ((c[1].x - c[0].x) * (c[2].y - c[0].y) - (c[2].x - c[0].x) * (c[1].y - c[0].y));
}

TEST(FrameScene, MirroredNodesKeepTheirFront) {
  for (const V3d& scale : {V3d(1, 1, 1), V3d(-1, 1, 1), V3d(1, -2, 1), V3d(-1, -1, 1), V3d(1, 1, -1)}) {
    SceneBuilder b;
    b.AddCamera();
    const int node = b.AddNode(-1, V3d(0), b.AddMesh(Triangle()));
    b.scene->nodes[size_t(node)].transform.scale = scale;
    const auto frame = MustBuild(b);
    const double determinant = scale.x * scale.y * scale.z;
    EXPECT_EQ(frame->primitives[0].mirrored, determinant < 0);
    // The triangle's front is the side that its mirrored normal (0, 0, 1) * scale points to.
    EXPECT_GT(SignedArea(*frame, 0) * scale.z, 0) << scale;
  }
}

TEST(FrameScene, NormalsByTheInverseTranspose) {
  MeshPrimitive slope = Triangle();
  slope.positions = {{0, 0, 0}, {1, 0, -1}, {0, 1, 0}};  // Normal (1, 0, 1).
  const auto n = float(std::sqrt(0.5));
  slope.normals.assign(3, V3f(n, 0, n));
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-2, 2);
  for (int trial = 0; trial < 50; ++trial) {
    SceneBuilder b;
    b.AddCamera();
    const int node = b.AddNode(-1, V3d(0), b.AddMesh(slope));
    NodeTransform& transform = b.scene->nodes[size_t(node)].transform;
    transform.scale = V3d(uniform(random), uniform(random), uniform(random));
    transform.rotation = Quatd(uniform(random), uniform(random), uniform(random), uniform(random));
    transform.rotation.normalize();
    const auto frame = MustBuild(b);
    ASSERT_TRUE(frame->primitives[0].has_normals);
    V3d corner[3];
    for (uint32_t v = 0; v < 3; ++v) {
      corner[v] = frame->view.ViewFromRaster(frame->ControlPoint(frame->primitives[0], v, 0));
    }
    const V3d geometric = (corner[1] - corner[0]).cross(corner[2] - corner[0]).normalized();
    const double mirrored = frame->primitives[0].mirrored ? -1 : 1;
    EXPECT_NEAR(V3d(frame->normals[0]).dot(geometric) * mirrored, 1, 1e-6) << "seed 7, trial " << trial;
  }
}

TEST(FrameScene, VertexThatIsNotFiniteChangesNothingElse) {
  SceneBuilder clean;
  clean.AddCamera();
  MeshPrimitive two = Triangle();
  two.positions.insert(two.positions.end(), {{0, 0, 1}, {1, 0, 1}, {0, 1, 1}});
  two.triangles.push_back({3, 4, 5});
  const int node = clean.AddNode(-1, V3d(0), clean.AddMesh(two));
  clean.AddChannel(node, AnimatedPath::kTranslation, {0, 1}, {0, 0, 0, 1, 0, 0});
  const auto expected = MustBuild(clean);

  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    SceneBuilder b = clean;
    b.scene = std::make_shared<Scene>(*clean.scene);
    b.scene->meshes[0].primitives[0].positions[1].y = bad;
    const auto frame = MustBuild(b);
    EXPECT_EQ(frame->dropped_triangles, 1);
    ASSERT_EQ(frame->triangles.size(), 1u);
    EXPECT_EQ(frame->triangles[0].vertices, (std::array<uint32_t, 3>{3, 4, 5}));
    ASSERT_FALSE(frame->warnings.empty());
    EXPECT_THAT(frame->warnings[0], HasSubstr("mesh"));
    EXPECT_EQ(0,
              std::memcmp(&frame->control_points[6], &expected->control_points[6], 6 * sizeof(RasterPoint)));
    EXPECT_EQ(frame->primitives[0].motion_pixels, expected->primitives[0].motion_pixels);
  }
}

TEST(FrameScene, ScenesFarFromTheOriginLookTheSame) {
  std::vector<RasterPoint> near;
  for (const double offset : {0.0, std::ldexp(1.0, 20)}) {
    SceneBuilder b;
    const int root = b.AddNode(-1, V3d(offset, -offset, offset));
    const int camera = b.AddCamera(root, V3d(0.25, 0.5, 4));
    b.scene->nodes[size_t(camera)].transform.rotation.setAxisAngle(V3d(0, 1, 0), 0.125);
    const int node = b.AddNode(root, V3d(0.5, 0, 0), b.AddMesh(Triangle()));
    b.AddChannel(node, AnimatedPath::kTranslation, {0, 1}, {0, 0, 0, 1, 0.5, 0});
    const auto frame = MustBuild(b);
    if (near.empty()) {
      near = frame->control_points;
    } else {
      ASSERT_EQ(near.size(), frame->control_points.size());
      for (size_t i = 0; i < near.size(); ++i) {
        EXPECT_NEAR(Raster(near[i]).x, Raster(frame->control_points[i]).x, 1e-12);
        EXPECT_NEAR(Raster(near[i]).y, Raster(frame->control_points[i]).y, 1e-12);
      }
    }
  }
}

TEST(FrameScene, ScaleChangesNothing) {
  std::vector<RasterPoint> first;
  for (const double scale : {1e-18, 1.0, 1e18}) {
    SceneBuilder b;
    const int root = b.AddNode();
    b.scene->nodes[size_t(root)].transform.scale = V3d(scale);
    const int node = b.AddNode(root, V3d(0), b.AddMesh(Triangle()));
    b.AddChannel(node, AnimatedPath::kTranslation, {0, 1}, {0, 0, 0, 1, 0.5, 0});
    const auto frame = MustBuild(b);
    ASSERT_EQ(frame->triangles.size(), 1u);
    EXPECT_EQ(frame->dropped_triangles, 0);
    if (first.empty()) first = frame->control_points;
    for (size_t i = 0; i < first.size(); ++i) {
      EXPECT_NEAR(Raster(first[i]).x, Raster(frame->control_points[i]).x, 1e-9) << scale;
      EXPECT_NEAR(Raster(first[i]).y, Raster(frame->control_points[i]).y, 1e-9) << scale;
      EXPECT_NEAR(first[i].z / first[i].w, frame->control_points[i].z / frame->control_points[i].w, 1e-12);
    }
  }
}

TEST(FrameScene, PathsThatTheMotionCannotFollowAreNamed) {
  for (const double angle : {0.02, 1.5}) {
    SceneBuilder b;
    b.AddCamera();
    MeshPrimitive blade = Triangle();
    const int node = b.AddNode(-1, V3d(0), b.AddMesh(blade, "blade"));
    const auto s = float(std::sin(angle / 2)), c = float(std::cos(angle / 2));
    b.AddChannel(node, AnimatedPath::kRotation, {0, 1}, {0, 0, 0, 1, 0, 0, s, c});
    RenderSettings straight = SquareSettings();
    straight.motion_degree = straight.motion_pieces = 1;
    const auto frame = MustBuild(b, straight);
    EXPECT_EQ(frame->primitives[0].degree, 1);
    EXPECT_EQ(frame->primitives[0].pieces, 1);
    // The arc of a corner 20 px from the centre lies 20 (1 - cos(angle / 2)) px outside of its chord.
    const double sagitta = 20 * (1 - std::cos(angle / 2));
    if (sagitta < 0.05) {
      EXPECT_THAT(frame->warnings, IsEmpty());
    } else {
      ASSERT_EQ(frame->warnings.size(), 1u);
      EXPECT_THAT(frame->warnings[0], HasSubstr("blade"));
      EXPECT_THAT(frame->warnings[0], HasSubstr("5.37 px"));
      EXPECT_NEAR(sagitta, 5.37, 0.005);
    }
    EXPECT_NEAR(frame->primitives[0].motion_pixels, 40 * std::sin(angle / 2), 1e-4);
    EXPECT_THAT(MustBuild(b)->warnings, IsEmpty());
  }
}

TEST(FrameScene, KeysInsideTheShutterAreChecked) {
  // There and back again within a tenth of the shutter, which no fixed times may see. The keys do not fall
  // on joints: the corner of the path at 0.6, where the speed turns by 800 px a shutter, is cut.
  SceneBuilder b;
  b.AddCamera();
  const int node = b.AddNode(-1, V3d(0), b.AddMesh(Triangle()));
  b.AddChannel(node, AnimatedPath::kTranslation, {0.55f, 0.6f, 0.65f}, {0, 0, 0, 1, 0, 0, 0, 0, 0});
  const auto frame = MustBuild(b);
  EXPECT_EQ(frame->primitives[0].pieces, kMaxMotionPieces);
  ASSERT_EQ(frame->warnings.size(), 1u);
  EXPECT_THAT(frame->warnings[0], HasSubstr("64 pieces"));
  const double x = Raster(frame->VertexAt(frame->primitives[0], 0, 0.6)).x;
  EXPECT_GT(x, 70 - 800 / 4.0 / kMaxMotionPieces);
  EXPECT_LT(x, 70 + 0.5);
}

TEST(FrameScene, CrossingTheNearPlaneIsInfiniteMotion) {
  SceneBuilder b;
  b.AddCamera();
  const int node = b.AddNode(-1, V3d(0), b.AddMesh(Triangle()));
  b.AddChannel(node, AnimatedPath::kTranslation, {0, 1}, {0, 0, 0, 0, 0, 10});
  const auto frame = MustBuild(b);
  EXPECT_EQ(frame->primitives[0].motion_pixels, std::numeric_limits<double>::infinity());
  EXPECT_EQ(frame->triangles.size(), 1u);
}

TEST(FrameScene, BuiltTwiceIsBitIdentical) {
  SceneBuilder b;
  b.AddCamera();
  MeshPrimitive cloud;
  std::mt19937 random(3);
  std::uniform_real_distribution<float> uniform(-1, 1);
  for (uint32_t i = 0; i < 30000; ++i) {
    cloud.positions.push_back({uniform(random), uniform(random), uniform(random)});
    if (i % 3 == 2) cloud.triangles.push_back({i - 2, i - 1, i});
  }
  cloud.normals = cloud.positions;
  const int node = b.AddNode(-1, V3d(0), b.AddMesh(cloud));
  b.AddChannel(node, AnimatedPath::kRotation, {0, 1}, {0, 0, 0, 1, 0, 1, 0, 0});
  const auto one = MustBuild(b), two = MustBuild(b);
  EXPECT_EQ(one->control_points, two->control_points);
  EXPECT_EQ(one->normals, two->normals);
  EXPECT_EQ(one->warnings, two->warnings);
  EXPECT_EQ(one->primitives[0].motion_pixels, two->primitives[0].motion_pixels);
}

}  // namespace
}  // namespace shutterline::engine::frame_scene_test
