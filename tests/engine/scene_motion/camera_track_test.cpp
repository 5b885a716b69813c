#include "worker/engine/scene/camera_track.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/engine/scene_motion/scene_builder.h"

namespace shutterline::engine::camera_track_test {
namespace {

constexpr int kFrame = 1;

/// The triangle's corners in the world, as SceneBuilder makes it.
const V3d kCorners[3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};

/// Points of the picture that a frame's own projection says corners are at, at mid-shutter, pixels.
void ExpectWhereTheFrameHasThem(const std::shared_ptr<const Scene>& scene, const RenderSettings& settings) {
  const auto frame = BuildFrameScene(scene, kFrame, settings);
  ASSERT_TRUE(frame.ok()) << frame.status();
  const auto track = CameraTrack::Make(*scene, settings);
  ASSERT_TRUE(track.ok()) << track.status();
  const auto matrices = track->At(kFrame);
  ASSERT_TRUE(matrices.ok()) << matrices.status();
  const FramePrimitive& primitive = (*frame)->primitives.at(0);
  for (uint32_t k = 0; k < 3; ++k) {
    const RasterPoint point = (*frame)->VertexAt(primitive, k, 0.5);
    V3d ndc;  // Divided by w.
    matrices->world_to_ndc.multVecMatrix(kCorners[k], ndc);
    EXPECT_NEAR(ndc.x * settings.width, point.x / point.w, 1e-6) << k;
    EXPECT_NEAR(ndc.y * settings.height, point.y / point.w, 1e-6) << k;
    // Left-handed: x to the right, y up, and z ahead.
    V3d in_view;
    matrices->world_to_camera.multVecMatrix(kCorners[k], in_view);
    const V3d view = (*frame)->view.ViewFromRaster(point);
    EXPECT_NEAR(in_view.x, view.x, 1e-6) << k;
    EXPECT_NEAR(in_view.y, view.y, 1e-6) << k;
    EXPECT_NEAR(in_view.z, -view.z, 1e-6) << k;
    EXPECT_GT(in_view.z, 0) << k;
  }
}

TEST(CameraTrack, PutsPointsWhereAFrameWithAMovingCameraHasThem) {
  SceneBuilder builder;
  builder.AddNode(-1, V3d(0), builder.AddMesh(Triangle()));
  const int camera = builder.AddCamera(-1, V3d(0.3, 0.4, 5));
  builder.AddChannel(camera, AnimatedPath::kTranslation, {0, 4}, {0.3f, 0.4f, 5, 2.3f, -0.6f, 9});
  RenderSettings settings = SquareSettings();
  settings.width = 160;
  ExpectWhereTheFrameHasThem(builder.scene, settings);

  // At the middle of the shutter: half way between 1 and 2 seconds.
  const auto matrices = CameraTrack::Make(*builder.scene, settings)->At(kFrame);
  ASSERT_TRUE(matrices.ok()) << matrices.status();
  V3d origin;
  matrices->world_to_camera.multVecMatrix(V3d(0.3 + 2 * 0.375, 0.4 - 0.375, 5 + 4 * 0.375), origin);
  EXPECT_NEAR(origin.length(), 0, 1e-6);
}

TEST(CameraTrack, KnowsTheAutomaticCameraAndOrthographicOnes) {
  SceneBuilder builder;
  builder.AddNode(-1, V3d(0), builder.AddMesh(Triangle()));
  RenderSettings settings = SquareSettings();
  settings.height = 60;
  ExpectWhereTheFrameHasThem(builder.scene, settings);
  builder.AddCamera();
  Camera& camera = builder.scene->cameras[0];
  camera.perspective = false;
  camera.xmag = camera.ymag = 3;
  camera.zfar = 20;
  ExpectWhereTheFrameHasThem(builder.scene, settings);
}

TEST(CameraTrack, SaysWhatIsNotThere) {
  SceneBuilder builder;
  builder.AddCamera();
  RenderSettings settings = SquareSettings();
  settings.camera = "none such";
  EXPECT_EQ(CameraTrack::Make(*builder.scene, settings).status().code(), absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace shutterline::engine::camera_track_test
