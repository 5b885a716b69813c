#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/engine/occlusion/occlusion_scene.h"

namespace shutterline::engine::motion_test {
namespace {

constexpr OcclusionPattern kPatterns[] = {OcclusionPattern::kPole, OcclusionPattern::kTilted};

OcclusionSettings Lines(int lines, OcclusionPattern pattern, bool motion = true) {
  OcclusionSettings settings;
  settings.lines = lines;
  settings.pattern = pattern;
  settings.motion = motion;
  return settings;
}

TEST(OcclusionMotion, ARisingSphereHasItsMeanOverTheShutter) {
  for (const OcclusionPattern pattern : kPatterns) {
    OcclusionScene scene;
    scene.AddMoving(Sphere({0, 0, 2}, 1, 64), Sphere({0, 0, 6}, 1, 64));
    // The mean of 1 / d² is 1 / (d0 d1).
    // Of tilted lines only few meet it.
    EXPECT_NEAR(1 - scene.Open(Lines(512, pattern)), 1.0 / 12, 1e-3);
    EXPECT_NEAR(1 - scene.Open(Lines(256, pattern, false)), 1.0 / 16, 3e-4);
  }
}

TEST(OcclusionMotion, ACurveIsFollowed) {
  for (const OcclusionPattern pattern : kPatterns) {
    // A disc that rises and comes back, quadratically: h = 1 + 4 t (1 - t), in two primitives' ways.
    const Mesh3 disc = Disc(1, 1, 256);
    const Placement placement;
    double mean = 0;
    constexpr int kSteps = 20000;
    for (int i = 0; i < kSteps; ++i) {
      const double t = (i + 0.5) / kSteps, h = 1 + 4 * t * (1 - t);
      mean += 1 / (1 + h * h) / kSteps;
    }
    for (const int pieces : {1, 2, 8}) {
      OcclusionScene scene;
      std::vector<RasterPoint> points;
      for (const V3d& p : disc.first) {
        for (int k = 0; k <= 2 * pieces; ++k) {
          // Control points of the piece: its ends, and the mean of the heights of their tangents' meeting.
          const auto height = [](double t) { return 4 * t * (1 - t); };
          const double t0 = double(k / 2) / pieces, t1 = t0 + 1.0 / pieces;
          const double rise = k % 2 == 0 ? height(t0) : height(t0) + (4 - 8 * t0) * (t1 - t0) / 2;
          points.push_back(scene.builder().Raster(placement.view(p + V3d(0, 0, rise))));
        }
      }
      scene.builder().AddCurvedMesh(points, 2, pieces, disc.second);
      EXPECT_NEAR(1 - scene.Open(Lines(512, pattern)), mean, 1e-3) << pieces;
    }
  }
}

TEST(OcclusionMotion, WhatMovesAlongIsStill) {
  for (const OcclusionPattern pattern : kPatterns) {
    for (uint64_t seed = 1; seed <= 5; ++seed) {
      SCOPED_TRACE(testing::Message() << "seed " << seed);
      std::mt19937_64 random(seed);
      std::uniform_real_distribution<double> unit(-1, 1);
      Mesh3 mesh;
      for (uint32_t i = 0; i < 30; ++i) {
        const V3d middle(2 * unit(random), 2 * unit(random), 1.2 + unit(random));
        for (int k = 0; k < 3; ++k)
          mesh.first.push_back(middle + V3d(unit(random), unit(random), unit(random)));
        mesh.second.push_back({3 * i, 3 * i + 1, 3 * i + 2});
      }
      const Mesh3 receiver{{{-0.01, -0.01, 0}, {0.02, -0.01, 0}, {-0.01, 0.02, 0}}, {{0, 1, 2}}};
      const V3d by(0.8, -0.5, 0.4), back(0, 0, -5);
      const auto open = [&](bool motion) {
        FrameSceneBuilder builder(PerspectiveView(64, 64));
        for (const Mesh3& m : {receiver, mesh}) {
          builder.AddViewMesh(Moved(m, back - 0.5 * by).first, Moved(m, back + 0.5 * by).first, m.second);
        }
        const auto occlusion = AmbientOcclusion::Create(builder.Build(), Lines(32, pattern, motion), 1);
        return occlusion.ok() ? occlusion->At(0, 1.0 / 3, 1.0 / 3) : -1;
      };
      EXPECT_NEAR(open(true), open(false), 1e-8);
    }
  }
}

TEST(OcclusionMotion, TheHemisphereTurnsWithTheTriangle) {
  // A triangle and a wall beside it that turn about the y axis by a quarter. Between, corners go straight,
  // which shrinks both across the axis; along it the wall is long.
  for (const OcclusionPattern pattern : kPatterns) {
    const auto turn = [](const V3d& p, double c, double s) {
      return V3d(c * p.x + s * p.z, p.y, -s * p.x + c * p.z) + V3d(0, 0, -5);
    };
    const Mesh3 receiver{{{-0.01, -0.01, 0}, {0.02, -0.01, 0}, {-0.01, 0.02, 0}}, {{0, 1, 2}}};
    const Mesh3 wall = Quad({0.5, -1e5, -2}, {0.5, 1e5, -2}, {0.5, 1e5, 2}, {0.5, -1e5, 2});
    const double c = std::sqrt(0.5);
    const auto open = [&](bool motion) {
      FrameSceneBuilder builder(PerspectiveView(64, 64));
      for (const Mesh3& m : {receiver, wall}) {
        std::vector<V3d> from, to;
        for (const V3d& p : m.first) {
          from.push_back(turn(p, c, -c));
          to.push_back(turn(p, c, c));
        }
        builder.AddViewMesh(from, to, m.second);
      }
      const auto occlusion = AmbientOcclusion::Create(builder.Build(), Lines(64, pattern, motion), 1);
      return occlusion.ok() ? occlusion->At(0, 1.0 / 3, 1.0 / 3) : -1;
    };
    EXPECT_NEAR(open(true), open(false), 1e-6);
    EXPECT_LT(open(true), 0.9);
  }
}

}  // namespace
}  // namespace shutterline::engine::motion_test
