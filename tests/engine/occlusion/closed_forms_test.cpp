#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/engine/occlusion/occlusion_scene.h"

namespace shutterline::engine::closed_forms_test {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr OcclusionPattern kPatterns[] = {OcclusionPattern::kPole, OcclusionPattern::kTilted};

OcclusionSettings Lines(int lines, OcclusionPattern pattern) {
  OcclusionSettings settings;
  settings.lines = lines;
  settings.pattern = pattern;
  return settings;
}

/// Between a small surface and a parallel rectangle whose corner is at height h over it.
double CornerFormFactor(double a, double b, double h) {
  const double x = a / h, y = b / h;
  return (x / std::sqrt(1 + x * x) * std::atan(y / std::sqrt(1 + x * x)) +
          y / std::sqrt(1 + y * y) * std::atan(x / std::sqrt(1 + y * y))) /
         (2 * kPi);
}

TEST(AmbientOcclusion, IsExactlyOpenInAnEmptyScene) {
  for (const OcclusionPattern pattern : kPatterns) {
    for (const int lines : {1, 2, 7, 16, 1024}) EXPECT_EQ(OcclusionScene().Open(Lines(lines, pattern)), 1);
  }
}

TEST(AmbientOcclusion, OfAWallIsItsFormFactor) {
  for (const OcclusionPattern pattern : kPatterns) {
    for (const double height : {0.5, 2.0, 1e4}) {
      OcclusionScene scene;
      const double far = 1e6, near = 1;
      scene.Add(Quad({near, -far, 0}, {near, far, 0}, {near, far, height}, {near, -far, height}));
      const double occluded = (1 - near / std::sqrt(near * near + height * height)) / 2;
      EXPECT_NEAR(1 - scene.Open(Lines(512, pattern)), occluded, 1e-4) << height;
    }
  }
}

TEST(AmbientOcclusion, OfARectangleOverheadIsItsFormFactor) {
  for (const OcclusionPattern pattern : kPatterns) {
    OcclusionScene scene;
    scene.Add(Quad({0, 0, 1}, {1.5, 0, 1}, {1.5, 0.7, 1}, {0, 0.7, 1}));
    EXPECT_NEAR(1 - scene.Open(Lines(512, pattern)), CornerFormFactor(1.5, 0.7, 1), 3e-4);
  }
}

TEST(AmbientOcclusion, OfADiscOverheadIsItsFormFactor) {
  for (const OcclusionPattern pattern : kPatterns) {
    OcclusionScene scene;
    scene.Add(Disc(0.8, 2, 2000));
    EXPECT_NEAR(1 - scene.Open(Lines(256, pattern)), 0.64 / (0.64 + 4), 1e-4);
  }
}

TEST(AmbientOcclusion, OfASphereIsTheSquareOfItsSine) {
  for (const OcclusionPattern pattern : kPatterns) {
    OcclusionScene scene;
    scene.Add(Sphere({0, 0, 3}, 1, 128));
    EXPECT_NEAR(1 - scene.Open(Lines(256, pattern)), 1.0 / 9, 2e-4);
    // Off the pole, by the cosine of its direction.
    OcclusionScene aslant;
    aslant.Add(Sphere({2, 1, 2}, 1, 128));
    EXPECT_NEAR(1 - aslant.Open(Lines(256, pattern)), (1.0 / 9) * (2.0 / 3), 2e-4);
  }
}

TEST(AmbientOcclusion, EndsAtTheRadius) {
  for (const OcclusionPattern pattern : kPatterns) {
    // Of a ceiling, a disc remains.
    OcclusionScene scene;
    scene.Add(Quad({-9, -9, 1}, {9, -9, 1}, {9, 9, 1}, {-9, 9, 1}));
    OcclusionSettings settings = Lines(256, pattern);
    settings.radius = 2;
    EXPECT_NEAR(scene.Open(settings), 0.25, 3e-4);
    settings.radius = 0.999;
    EXPECT_EQ(scene.Open(settings), 1);
  }
}

TEST(AmbientOcclusion, FallsOffUnderACeiling) {
  for (const OcclusionPattern pattern : kPatterns) {
    OcclusionScene scene;
    const double far = 1e3;
    scene.Add(Quad({-far, -far, 1}, {far, -far, 1}, {far, far, 1}, {-far, far, 1}));
    for (const double radius : {1.25, 2.0, 10.0, 300.0}) {
      SCOPED_TRACE(radius);
      const double c = 1 / radius;
      OcclusionSettings settings = Lines(256, pattern);
      settings.radius = radius;
      settings.falloff = OcclusionFalloff::kLinear;
      const double tolerance = pattern == OcclusionPattern::kPole ? 1e-6 : 2e-4;
      EXPECT_NEAR(scene.Open(settings), 2 * c - c * c, tolerance);
      settings.falloff = OcclusionFalloff::kQuadratic;
      EXPECT_NEAR(scene.Open(settings), c * c - 2 * c * c * std::log(c), tolerance);
    }
  }
}

TEST(AmbientOcclusion, OfTwoLayersWithFallOffTheNearerCounts) {
  for (const OcclusionPattern pattern : kPatterns) {
    OcclusionSettings settings = Lines(64, pattern);
    settings.radius = 4;
    settings.falloff = OcclusionFalloff::kLinear;
    OcclusionScene one, two;
    const Mesh3 roof = Quad({-5, -5, 1}, {5, -5, 1}, {5, 5, 1}, {-5, 5, 1});
    one.Add(roof);
    two.Add(Moved(roof, {0, 0, 1}));
    two.Add(Disc(1, 3, 5));
    two.Add(roof);
    EXPECT_EQ(one.Open(settings), two.Open(settings));
    // Two planes that cross: a gable. By symmetry it is twice one half of it.
    OcclusionScene gable, left;
    const Mesh3 slope = Quad({-9, -9, -8}, {9, -9, 10}, {9, 9, 10}, {-9, 9, -8});
    const Mesh3 counter = Quad({9, -9, -8}, {-9, -9, 10}, {-9, 9, 10}, {9, 9, -8});
    gable.Add(slope);
    gable.Add(counter);
    left.Add(Quad({-9, -9, -8}, {0, -9, 1}, {0, 9, 1}, {-9, 9, -8}));
    left.Add(Quad({9, -9, -8}, {0, -9, 1}, {0, 9, 1}, {9, 9, -8}));
    EXPECT_NEAR(gable.Open(settings), left.Open(settings), 3e-6);
    EXPECT_LT(gable.Open(settings), 0.5);
  }
}

TEST(AmbientOcclusion, InABoxIsExactlyClosed) {
  for (const OcclusionPattern pattern : kPatterns) {
    for (const double size : {0.03, 1.0, 300.0}) {
      OcclusionScene scene;
      const double s = size, f = -0.1 * size, x = -0.7 * size, y = -0.4 * size;
      const V3d a(x, y, f), b(s, y, f), c(s, s, f), d(x, s, f), up(0, 0, s);
      scene.Add(Quad(a, b, b + up, a + up));
      scene.Add(Quad(b, c, c + up, b + up));
      scene.Add(Quad(c, d, d + up, c + up));
      scene.Add(Quad(d, a, a + up, d + up));
      scene.Add(Quad(a + up, b + up, c + up, d + up));
      EXPECT_EQ(scene.Open(Lines(64, pattern)), 0) << size;
    }
    OcclusionScene ball;
    ball.Add(Sphere({0.1, 0.2, 0.1}, 0.9, 40));
    EXPECT_EQ(ball.Open(Lines(64, pattern)), 0);
  }
}

TEST(AmbientOcclusion, RefusesSettingsOutOfTheirRange) {
  const auto frame = OcclusionScene().Build();
  OcclusionSettings settings;
  for (const int lines : {0, -1, kMaxOcclusionLines + 1}) {
    settings.lines = lines;
    EXPECT_EQ(AmbientOcclusion::Create(frame, settings, 1).status().code(),
              absl::StatusCode::kInvalidArgument);
  }
  settings = {};
  for (const double radius : {0.0, -1.0, std::nan(""), double(INFINITY)}) {
    settings.radius = radius;
    EXPECT_EQ(AmbientOcclusion::Create(frame, settings, 1).status().code(),
              absl::StatusCode::kInvalidArgument);
  }
  settings = {};
  settings.falloff = OcclusionFalloff::kLinear;
  EXPECT_EQ(AmbientOcclusion::Create(frame, settings, 1).status().code(), absl::StatusCode::kInvalidArgument);
}

}  // namespace
}  // namespace shutterline::engine::closed_forms_test
