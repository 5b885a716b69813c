#include "tests/scenes/scene_generators.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/scenes/keys.h"

namespace shutterline::scenes {
namespace {

using testing::HasSubstr;

TEST(Scenes, TrianglesArePromised) {
  EXPECT_EQ(GenerateScene("plane")->DrawnTriangles(), 2 * 16 * 16);
  SceneOptions fine;
  fine.tessellation = 64;
  EXPECT_EQ(GenerateScene("plane", fine)->DrawnTriangles(), 2 * 64 * 64);
  EXPECT_EQ(GenerateScene("debris")->DrawnTriangles(), 5000);
  EXPECT_EQ(GenerateScene("trees")->DrawnTriangles(), 270000 + 512);
  EXPECT_EQ(GenerateScene("static")->DrawnTriangles(), 100000);
  // The papers' scenes have 29,068, 88,120, about 92,230 and 66,450.
  EXPECT_NEAR(double(GenerateScene("chess")->DrawnTriangles()), 29068, 0.02 * 29068);
  EXPECT_NEAR(double(GenerateScene("armadillo")->DrawnTriangles()), 88120, 0.01 * 88120);
  EXPECT_EQ(GenerateScene("clothball")->DrawnTriangles(), 2 * (196 * 196 + 84 * 64 + 48 * 48));
  EXPECT_NEAR(double(GenerateScene("hall")->DrawnTriangles()), 66450, 0.02 * 66450);
  const int64_t demo = GenerateScene("demo")->DrawnTriangles();
  EXPECT_GE(demo, 10000);
  EXPECT_LE(demo, 25000);
}

TEST(Scenes, OptionsAreHeld) {
  SceneOptions options;
  options.triangles = 123;
  EXPECT_EQ(GenerateScene("debris", options)->DrawnTriangles(), 123);
  EXPECT_THAT(std::string(GenerateScene("plane", options).status().message()),
              HasSubstr("does not take --triangles"));
  options.triangles = 0;
  EXPECT_THAT(std::string(GenerateScene("debris", options).status().message()),
              HasSubstr("--triangles is 0"));
  options = {};
  options.motion_pixels = std::nan("");
  EXPECT_EQ(GenerateScene("plane", options).status().code(), absl::StatusCode::kInvalidArgument);
  const auto unknown = GenerateScene("teapot");
  EXPECT_EQ(unknown.status().code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(std::string(unknown.status().message()), HasSubstr("debris"));
}

TEST(Scenes, SmallestAndOddSizesWork) {
  for (const SceneInfo& info : AllScenes()) {
    SceneOptions options;
    if (info.min_triangles <= info.max_triangles) options.triangles = info.min_triangles;
    if (info.min_tessellation <= info.max_tessellation) options.tessellation = info.min_tessellation;
    if (info.max_motion >= 0) options.motion_pixels = 0;
    EXPECT_TRUE(GenerateGlb(info.name, options).ok()) << info.name;
    if (options.tessellation) options.tessellation = 7;
    if (options.triangles) options.triangles = info.min_triangles + 13;
    EXPECT_TRUE(GenerateGlb(info.name, options).ok()) << info.name;
  }
}

const Channel& OnlyChannel(const GlbScene& scene) {
  EXPECT_EQ(scene.channels.size(), 1u);
  return scene.channels.front();
}

/// glTF's LINEAR interpolation, for what is not a rotation.
V3d ValueAt(const Channel& channel, double time, size_t width) {
  const auto next = std::upper_bound(channel.times.begin(), channel.times.end(), float(time));
  const size_t k = std::clamp<size_t>(size_t(next - channel.times.begin()), 1, channel.times.size() - 1);
  const double s = (time - channel.times[k - 1]) / (double(channel.times[k]) - channel.times[k - 1]);
  V3d result(0);
  for (size_t i = 0; i < width; ++i) {
    const double a = channel.values[(k - 1) * width + i], b = channel.values[k * width + i];
    result[int(i)] = a + (b - a) * std::clamp(s, 0.0, 1.0);
  }
  return result;
}

double RasterX(const V3d& p) {
  return 512 + p.x / -p.z * 384 / std::tan(kDefaultYfov / 2);
}

TEST(Scenes, PlaneMovesBySixtyPixelsInEveryFrame) {
  const GlbScene scene = GenerateScene("plane").value();
  const Channel& channel = OnlyChannel(scene);
  for (int frame = 0; frame < kAnimatedFrames; ++frame) {
    const double open = RasterX(ValueAt(channel, frame / 24.0, 3));
    const double middle = RasterX(ValueAt(channel, (frame + 0.25) / 24.0, 3));
    const double close = RasterX(ValueAt(channel, (frame + 0.5) / 24.0, 3));
    EXPECT_NEAR(std::abs(close - open), 60, 1e-3) << frame;
    EXPECT_NEAR(middle, (open + close) / 2, 1e-3) << frame;
  }
}

TEST(Scenes, TreesPassBy29To64Pixels) {
  const GlbScene scene = GenerateScene("trees").value();
  const Channel& channel = OnlyChannel(scene);
  const double way = (ValueAt(channel, 0.5 / 24, 3) - ValueAt(channel, 0, 3)).length();
  double least = 1e9, most = 0;
  for (const Node& node : scene.nodes) {
    if (node.mesh < 0) continue;
    for (const Primitive& primitive : scene.meshes[size_t(node.mesh)].primitives) {
      for (const V3f& p : primitive.positions) {
        const V3f world = node.rotation.rotateVector(p * node.scale) + node.translation;
        const double pixels = way * PixelsPerMetre(scene.cameras[0].yfov, -world.z);
        least = std::min(least, pixels);
        most = std::max(most, pixels);
      }
    }
  }
  EXPECT_GE(least, 29);
  EXPECT_LE(most, 64.001);
}

TEST(Scenes, FanTurnsThirtyDegreesAndWrapsNowhere) {
  const GlbScene scene = GenerateScene("fan").value();
  const Channel& channel = OnlyChannel(scene);
  for (size_t k = 1; k < channel.times.size(); ++k) {
    double dot = 0;
    for (size_t i = 0; i < 4; ++i) {
      dot += double(channel.values[4 * (k - 1) + i]) * double(channel.values[4 * k + i]);
    }
    const double degrees = 2 * std::acos(std::min(1.0, dot)) * 180 / M_PI;
    const double shutters = (double(channel.times[k]) - channel.times[k - 1]) / kShutterSeconds;
    EXPECT_NEAR(degrees / shutters, 30, 0.01);
  }
}

/// Degrees of a shutter that two neighbouring keys of a rotation are apart.
double DegreesAShutter(const Channel& channel, size_t key) {
  double dot = 0;
  for (size_t i = 0; i < 4; ++i) {
    dot += double(channel.values[4 * key + i]) * double(channel.values[4 * key + 4 + i]);
  }
  const double degrees = 2 * std::acos(std::min(1.0, std::abs(dot))) * 180 / M_PI;
  return degrees * kShutterSeconds / (double(channel.times[key + 1]) - channel.times[key]);
}

TEST(Scenes, ClothTurnsByAnEighthOfATurnAndHallPansBy32Pixels) {
  const GlbScene cloth = GenerateScene("clothball").value();
  const GlbScene hall = GenerateScene("hall").value();
  for (size_t k = 0; k < 3; ++k) {
    EXPECT_NEAR(DegreesAShutter(OnlyChannel(cloth), k), 45, 0.01);
    const double radians = DegreesAShutter(OnlyChannel(hall), k) * M_PI / 180;
    EXPECT_NEAR(radians * PixelsPerMetre(hall.cameras[0].yfov, 1), 32, 0.01);
  }
}

/// Taken together, the pieces have every triangle, and every piece flies.
TEST(Scenes, ArmadilloFliesInPieces) {
  const GlbScene scene = GenerateScene("armadillo").value();
  size_t pieces = 0;
  for (const Node& node : scene.nodes) pieces += node.name == "piece";
  EXPECT_GT(pieces, 100u);
  EXPECT_EQ(scene.channels.size(), 2 * pieces);
}

TEST(Scenes, SwingRotationTurnsAboutItsAxisBackAndForth) {
  const Imath::Quatf base = Turn(V3f(1, 0, 0), 50);
  const Channel channel = SwingRotation(3, V3f(0, 1, 0), 10, base);
  EXPECT_NEAR(DegreesAShutter(channel, 0), 10, 1e-3);
  const auto key = [&](size_t k) {
    const float* q = &channel.values[4 * k];
    return Imath::Quatf(q[3], q[0], q[1], q[2]);
  };
  const V3f p(0.3f, -0.2f, 0.9f);
  EXPECT_LT((key(1).rotateVector(p) - Turn(V3f(0, 1, 0), 20).rotateVector(base.rotateVector(p))).length(),
            1e-5f);
  EXPECT_LT((key(0).rotateVector(p) - key(2).rotateVector(p)).length(), 1e-6f);
}

TEST(Scenes, DebrisStaysBelowItsFastest) {
  SceneOptions options;
  options.motion_pixels = 10;
  const GlbScene scene = GenerateScene("debris", options).value();
  const Channel& channel = OnlyChannel(scene);
  const double part = ValueAt(channel, 0.5 / 24, 1).x;
  EXPECT_NEAR(part, 1 / kLegShutters, 1e-6);
  const Primitive& primitive = scene.meshes[0].primitives[0];
  double most = 0;
  for (size_t i = 0; i < primitive.positions.size(); ++i) {
    const V3f &p = primitive.positions[i], &way = primitive.morph_offsets[i];
    most = std::max(most, part * way.length() * PixelsPerMetre(kDefaultYfov, -p.z));
    EXPECT_LT(p.z, -1);
    EXPECT_LT((p + way).z, -1);
    EXPECT_EQ(primitive.colors[i], primitive.colors[i / 3 * 3]);
  }
  EXPECT_GT(most, 8);
  EXPECT_LT(most, 12);  // A corner may be nearer than the centre that the speed refers to.
}

TEST(Scenes, CameraLooksAtItsTarget) {
  GlbScene scene;
  const V3f eye(-0.1f, 0.3f, 0.86f), target(0, 0.19f, 0);
  const Node node = CameraNode(scene, {0.6}, eye, target);
  const V3f forward = node.rotation.rotateVector(V3f(0, 0, -1));
  EXPECT_LT((forward - (target - eye).normalized()).length(), 1e-5f);
  EXPECT_LT(std::abs(node.rotation.rotateVector(V3f(1, 0, 0)).y), 1e-6f);  // No roll.
  EXPECT_GT(node.rotation.rotateVector(V3f(0, 1, 0)).y, 0);
}

TEST(Scenes, TurnsAreRightHanded) {
  const V3f y = Turn(V3f(0, 0, 1), 90).rotateVector(V3f(1, 0, 0));
  EXPECT_LT((y - V3f(0, 1, 0)).length(), 1e-6f);
}

}  // namespace
}  // namespace shutterline::scenes
