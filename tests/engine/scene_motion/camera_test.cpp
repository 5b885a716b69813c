#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "tests/engine/scene_motion/scene_builder.h"
#include "worker/engine/scene/auto_camera.h"
#include "worker/engine/scene/camera_pose.h"
#include "worker/engine/scene/camera_select.h"

namespace shutterline::engine::camera_test {
namespace {

using ::testing::HasSubstr;

Camera Orthographic() {
  Camera camera;
  camera.perspective = false;
  camera.xmag = 2;
  camera.ymag = 1;
  camera.znear = 1;
  camera.zfar = 11;
  return camera;
}

TEST(FrameView, PerspectiveDepthIsReversed) {
  Camera camera;
  camera.znear = 0.25;
  camera.zfar = 100;
  const auto view = MakeFrameView(camera, 640, 480);
  ASSERT_TRUE(view.ok());
  const RasterPoint near = view->RasterFromView({0, 0, -0.25});
  EXPECT_EQ(near.z / near.w, 1);
  const RasterPoint far = view->RasterFromView({0, 0, -100});
  EXPECT_EQ(far.z / far.w, view->FarDepth());
  EXPECT_EQ(view->FarDepth(), 0.0025);
  EXPECT_LT(far.z / far.w, near.z / near.w);
  const RasterPoint closer = view->RasterFromView({0, 0, -0.2});
  EXPECT_GT(closer.z, closer.w);
  camera.zfar = 0;
  EXPECT_EQ(MakeFrameView(camera, 640, 480)->FarDepth(), 0);
}

TEST(FrameView, YfovSpansTheHeight) {
  Camera camera;
  camera.yfov = 1.1;
  camera.aspect_ratio = 5;  // The frame's own shape counts.
  const auto view = MakeFrameView(camera, 300, 200);
  const double top = std::tan(0.55);
  const V2d corner = Raster(view->RasterFromView({top * 1.5 * 7, top * 7, -7}));
  EXPECT_NEAR(corner.x, 300, 1e-10);
  EXPECT_NEAR(corner.y, 0, 1e-10);
  EXPECT_NEAR(Raster(view->RasterFromView({0, -top, -1})).y, 200, 1e-10);
}

TEST(FrameView, OrthographicShowsTheWholeBox) {
  const Camera camera = Orthographic();
  // 4 by 2 metres fit 400 x 300 px at 100 px a metre, and 300 x 100 px at 50.
  const auto wide = MakeFrameView(camera, 400, 300);
  EXPECT_EQ(Raster(wide->RasterFromView({2, 1, -3})), V2d(400, 50));
  const auto flat = MakeFrameView(camera, 300, 100);
  EXPECT_EQ(Raster(flat->RasterFromView({-2, -1, -3})), V2d(50, 100));
  EXPECT_EQ(wide->RasterFromView({0, 0, -1}).z, 1);
  EXPECT_EQ(wide->RasterFromView({0, 0, -11}).z, 0);
  EXPECT_EQ(wide->RasterFromView({0, 0, -6}).z, 0.5);
  EXPECT_EQ(wide->FarDepth(), 0);
}

TEST(FrameView, ViewFromRasterUndoesRasterFromView) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-10, 10);
  Camera perspective;
  for (const Camera& camera : {perspective, Orthographic()}) {
    const auto view = MakeFrameView(camera, 1920, 1080);
    for (int i = 0; i < 1000; ++i) {
      const V3d p(uniform(random), uniform(random), uniform(random));
      const V3d back = view->ViewFromRaster(view->RasterFromView(p));
      EXPECT_LT((back - p).length(), 1e-12) << "seed 5, point " << i;
    }
  }
}

TEST(FrameView, ImpossibleCamerasAreRefusedByName) {
  const auto message = [](const Camera& camera) {
    const absl::Status status = MakeFrameView(camera, 10, 10).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    return std::string(status.message());
  };
  Camera c;
  c.znear = 0;
  EXPECT_THAT(message(c), HasSubstr("znear is 0"));
  c = {};
  c.zfar = 0.05;
  EXPECT_THAT(message(c), HasSubstr("zfar is 0.05"));
  c = {};
  c.yfov = std::numbers::pi;
  EXPECT_THAT(message(c), HasSubstr("yfov"));
  c = {};
  c.znear = std::nan("");
  EXPECT_THAT(message(c), HasSubstr("znear"));
  c = Orthographic();
  c.xmag = 0;
  EXPECT_THAT(message(c), HasSubstr("xmag"));
  c = Orthographic();
  c.zfar = 1;
  EXPECT_THAT(message(c), HasSubstr("zfar"));
}

TEST(CameraPose, ScaleAndShearOfTheNodeAreIgnored) {
  M44d m;
  m.setAxisAngle(V3d(0, 1, 0), 0.3);
  m[3][0] = 5;
  const auto plain = CameraPoseFrom(m);
  M44d scaled = m;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) scaled[row][column] *= row + 2;
  }
  const auto pose = CameraPoseFrom(scaled);
  ASSERT_TRUE(plain && pose);
  EXPECT_LT((plain->right - pose->right).length(), 1e-15);
  EXPECT_LT((plain->back - V3d(std::sin(0.3), 0, std::cos(0.3))).length(), 1e-15);
  EXPECT_EQ(pose->position, V3d(5, 0, 0));
  EXPECT_NEAR(pose->right.cross(pose->up).dot(pose->back), 1, 1e-15);
  M44d flat = m;
  for (int column = 0; column < 3; ++column) flat[1][column] = flat[2][column];
  EXPECT_FALSE(CameraPoseFrom(flat));
  M44d zero;
  zero.setScale(0.0);
  EXPECT_FALSE(CameraPoseFrom(zero));
}

TEST(SelectCamera, NamesIndicesAndTheFirstNode) {
  SceneBuilder b;
  const int first = b.AddCamera(), second = b.AddCamera();
  b.AddCamera();
  b.scene->cameras[0].name = "1";
  b.scene->cameras[1].name = "side";
  b.scene->nodes[size_t(second)].name = "boom";
  // The third camera's node is not in the default scene; two nodes place the second camera.
  b.scene->roots.pop_back();
  const int again = b.AddNode();
  b.scene->nodes[size_t(again)].camera = 1;
  EXPECT_EQ(SelectCamera(*b.scene, "")->node, first);
  EXPECT_EQ(SelectCamera(*b.scene, "side")->node, second);
  EXPECT_EQ(SelectCamera(*b.scene, "boom")->node, second);
  EXPECT_EQ(SelectCamera(*b.scene, "1")->node, first);  // The name goes before the index.
  EXPECT_EQ(SelectCamera(*b.scene, "0")->node, first);
  EXPECT_THAT(std::string(SelectCamera(*b.scene, "2").status().message()), HasSubstr("not placed"));
  const absl::Status unknown = SelectCamera(*b.scene, "front").status();
  EXPECT_EQ(unknown.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(unknown.message()), HasSubstr("\"side\""));
  RenderSettings settings;
  settings.camera = "front";
  EXPECT_EQ(ValidateAgainstScene(*b.scene, settings), unknown);
  EXPECT_EQ(BuildFrameScene(b.scene, 0, settings).status(), unknown);
  b.scene->cameras[1].znear = -1;
  EXPECT_THAT(std::string(SelectCamera(*b.scene, "side").status().message()), HasSubstr("znear"));
  b.scene->roots.clear();
  EXPECT_TRUE(SelectCamera(*b.scene, "")->IsAutomatic());
}

TEST(AutoCamera, FramesBoxesOfAnySizeAndShape) {
  for (const double scale : {1e-18, 1e-3, 1.0, 1e18}) {
    for (const V3d& size : {V3d(1, 1, 1), V3d(10, 0.1, 1), V3d(1, 0, 1), V3d(0, 3, 0)}) {
      for (const int width : {100, 400}) {
        const V3d center = scale * V3d(3, -2, 1);
        const Box3d box(center - scale * size, center + scale * size);
        const AutoCamera made = MakeAutoCamera(box, width, 200);
        const auto view = MakeFrameView(made.camera, width, 200);
        ASSERT_TRUE(view.ok()) << view.status().ToString();
        M44d world;
        const M44d view_from_world = made.pose.ViewFrom(world);
        double reach = 0;
        for (int corner = 0; corner < 8; ++corner) {
          const V3d p(corner & 1 ? box.max.x : box.min.x, corner & 2 ? box.max.y : box.min.y,
                      corner & 4 ? box.max.z : box.min.z);
          const RasterPoint r = view->RasterFromView(p * view_from_world);
          EXPECT_LT(r.z, r.w) << scale;
          const V2d at = Raster(r);
          reach = std::max({reach, std::abs(at.x / width * 2 - 1), std::abs(at.y / 200 * 2 - 1)});
        }
        EXPECT_NEAR(reach, 0.9, 1e-6) << scale << " " << size << " " << width;
      }
    }
  }
}

TEST(AutoCamera, StandsStillInEveryFrame) {
  SceneBuilder b;
  const int node = b.AddNode(-1, V3d(0), b.AddMesh(Triangle()));
  b.AddNode(-1, V3d(0, 2, 0), 0);
  b.AddChannel(node, AnimatedPath::kTranslation, {0, 4}, {0, 0, 0, 8, 0, 0});
  const auto one = BuildFrameScene(b.scene, 0, SquareSettings());
  const auto two = BuildFrameScene(b.scene, 2, SquareSettings());
  ASSERT_TRUE(one.ok() && two.ok());
  const FramePrimitive& still = (*one)->primitives[1];
  EXPECT_EQ(still.degree, 0);
  for (uint32_t v = 3; v < 6; ++v) {
    EXPECT_EQ((*one)->ControlPoint(still, v, 0), (*two)->ControlPoint((*two)->primitives[1], v, 0));
  }
}

}  // namespace
}  // namespace shutterline::engine::camera_test
