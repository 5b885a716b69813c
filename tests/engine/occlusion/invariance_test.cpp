#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "tests/engine/occlusion/occlusion_scene.h"
#include "tests/support/only_target.h"
#include "tests/support/random_soup.h"

namespace shutterline::engine::invariance_test {
namespace {

constexpr OcclusionPattern kPatterns[] = {OcclusionPattern::kPole, OcclusionPattern::kTilted};

V3d RandomUnit(std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  const V3d v(normal(random), normal(random), normal(random));
  return v / v.length();
}

/// The convex hull of points of an ellipsoid, by trying all planes.
Mesh3 RandomConvex(std::mt19937_64& random, int points) {
  Mesh3 mesh;
  for (int i = 0; i < points; ++i) mesh.first.push_back(RandomUnit(random) * V3d(1, 0.7, 0.4));
  for (uint32_t a = 0; a < uint32_t(points); ++a) {
    for (uint32_t b = a + 1; b < uint32_t(points); ++b) {
      for (uint32_t c = b + 1; c < uint32_t(points); ++c) {
        const V3d normal = (mesh.first[b] - mesh.first[a]).cross(mesh.first[c] - mesh.first[a]);
        int above = 0, below = 0;
        for (uint32_t i = 0; i < uint32_t(points); ++i) {
          if (i == a || i == b || i == c) continue;
          (normal.dot(mesh.first[i] - mesh.first[a]) > 0 ? above : below)++;
        }
        if (above == 0) mesh.second.push_back({a, b, c});
        if (below == 0) mesh.second.push_back({a, c, b});
      }
    }
  }
  return mesh;
}

/// Random triangles in the upper half space, all in one mesh or in an order of their own.
std::vector<Mesh3> RandomTriangles(std::mt19937_64& random, int count) {
  std::uniform_real_distribution<double> unit(-1, 1);
  std::vector<Mesh3> meshes;
  for (int i = 0; i < count; ++i) {
    const V3d middle(3 * unit(random), 3 * unit(random), 1.5 + 1.5 * unit(random));
    std::vector<V3d> corners;
    for (int k = 0; k < 3; ++k) corners.push_back(middle + RandomUnit(random));
    meshes.push_back({corners, {{0, 1, 2}}});
  }
  return meshes;
}

std::vector<OcclusionSettings> AllSettings(int lines) {
  std::vector<OcclusionSettings> all;
  for (const OcclusionPattern pattern : kPatterns) {
    for (const OcclusionFalloff falloff :
         {OcclusionFalloff::kNone, OcclusionFalloff::kLinear, OcclusionFalloff::kQuadratic}) {
      OcclusionSettings settings;
      settings.lines = lines;
      settings.pattern = pattern;
      settings.falloff = falloff;
      if (falloff != OcclusionFalloff::kNone) settings.radius = 3;
      all.push_back(settings);
    }
  }
  return all;
}

TEST(OcclusionInvariance, AConvexMeshDoesNotOccludeItself) {
  for (uint64_t seed = 1; seed <= 12; ++seed) {
    std::mt19937_64 random(seed);
    const Mesh3 mesh = RandomConvex(random, 24);
    for (const double scale : {1e-3, 1.0, 1e6}) {
      for (const double away : {3.0, 1e3, 1e6}) {  // In sizes of the mesh.
        SCOPED_TRACE(testing::Message() << "seed " << seed << ", scale " << scale << ", away " << away);
        std::vector<V3d> points;
        const V3d centre = away * V3d(0.4, -0.3, -1);
        for (const V3d& p : mesh.first) points.push_back(scale * (p + centre));
        FrameSceneBuilder builder(PerspectiveView(64, 64));
        builder.AddViewMesh(points, {}, mesh.second);
        for (const OcclusionSettings& settings : AllSettings(5)) {
          const auto occlusion = AmbientOcclusion::Create(builder.Build(), settings, 1);
          ASSERT_TRUE(occlusion.ok());
          for (uint32_t i = 0; i < mesh.second.size(); ++i) {
            // Only from outside: what faces away from the camera is asked for its inside.
            const V3d face = (points[mesh.second[i][1]] - points[mesh.second[i][0]])
                                 .cross(points[mesh.second[i][2]] - points[mesh.second[i][0]]);
            if (face.dot(points[mesh.second[i][0]]) > 0) continue;
            for (const auto& [b1, b2] : {std::pair(1.0 / 3, 1.0 / 3), {0.5, 0.0}, {1e-9, 0.3}, {1.0, 0.0}}) {
              ASSERT_EQ(occlusion->At(i, b1, b2), 1) << "triangle " << i;
            }
          }
        }
      }
    }
  }
}

TEST(OcclusionInvariance, AFlatMeshDoesNotOccludeItself) {
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937_64 random(seed);
    const V3d n = RandomUnit(random), a = n.cross(RandomUnit(random)), b = n.cross(a);
    const V3d corner = 1e3 * RandomUnit(random);
    std::vector<V3d> points;
    std::vector<std::array<uint32_t, 3>> triangles;
    constexpr uint32_t kSide = 12;
    for (uint32_t y = 0; y <= kSide; ++y) {
      for (uint32_t x = 0; x <= kSide; ++x) {
        points.push_back(corner + double(x) * a + std::pow(double(y), 1.5) * b);
        if (x == kSide || y == kSide) continue;
        const uint32_t i = y * (kSide + 1) + x;
        triangles.push_back({i, i + 1, i + kSide + 1});
        triangles.push_back({i + 1, i + kSide + 2, i + kSide + 1});
      }
    }
    FrameSceneBuilder builder(PerspectiveView(64, 64));
    builder.AddViewMesh(points, {}, triangles);
    builder.AddViewMesh(points, {}, triangles);  // All twice.
    OcclusionSettings settings;
    const auto occlusion = AmbientOcclusion::Create(builder.Build(), settings, 1);
    ASSERT_TRUE(occlusion.ok());
    for (uint32_t i = 0; i < 2 * triangles.size(); ++i) ASSERT_EQ(occlusion->At(i, 0.25, 0.5), 1) << i;
  }
}

TEST(OcclusionInvariance, NeitherOrderNorProcessorMatters) {
  for (uint64_t seed = 1; seed <= 6; ++seed) {
    std::mt19937_64 random(seed);
    std::vector<Mesh3> meshes = RandomTriangles(random, 60);
    std::vector<Mesh3> close = meshes;
    for (Mesh3& mesh : close) mesh = Moved(mesh, 0.7 * RandomUnit(random));
    std::vector<size_t> order(meshes.size());
    for (size_t i = 0; i < order.size(); ++i) order[i] = i;
    const auto open = [&](const OcclusionSettings& settings) {
      OcclusionScene scene;
      for (const size_t i : order) {
        i % 3 == 0 ? scene.Add(meshes[i]) : scene.AddMoving(meshes[i], close[i]);
      }
      return scene.Open(settings);
    };
    for (const OcclusionSettings& settings : AllSettings(16)) {
      SCOPED_TRACE(testing::Message() << "seed " << seed << ", fall-off " << int(settings.falloff));
      const double expected = open(settings);
      EXPECT_GT(expected, 0);
      EXPECT_LT(expected, 1);
      std::shuffle(order.begin(), order.end(), random);
      EXPECT_EQ(open(settings), expected);
      ForEachTarget([&] { EXPECT_EQ(open(settings), expected); });
    }
  }
}

TEST(OcclusionInvariance, NeitherSizeNorPlaceNorDirectionMatters) {
  for (uint64_t seed = 1; seed <= 8; ++seed) {
    std::mt19937_64 random(seed);
    const std::vector<Mesh3> meshes = RandomTriangles(random, 40);
    const V3d z = RandomUnit(random), x = z.cross(RandomUnit(random)).normalized(), y = z.cross(x);
    const auto open = [&](const Placement& placement, OcclusionSettings settings) {
      OcclusionScene scene(placement);
      for (const Mesh3& mesh : meshes) scene.Add(mesh);
      return scene.Open(settings);
    };
    for (OcclusionSettings settings : AllSettings(16)) {
      SCOPED_TRACE(testing::Message() << "seed " << seed << ", fall-off " << int(settings.falloff));
      const double expected = open({}, settings);
      for (const double scale : {1e-3, 1e6}) {
        OcclusionSettings scaled = settings;
        if (settings.radius) scaled.radius = *settings.radius * scale;
        const Placement placement{[&](const V3d& p) { return scale * (p + V3d(0, 0, -5)); }};
        EXPECT_NEAR(open(placement, scaled), expected, 1e-7) << scale;
      }
      // The lines are turned otherwise.
      settings.lines = 512;
      const Placement turned{
          [&](const V3d& p) { return p.x * x + p.y * y + p.z * z + 20.0 * V3d(1, 2, -3) - 6.0 * z; }};
      const double many = open({}, settings);
      const double other = open(turned, settings);
      // The camera may be on the other side then.
      if ((20.0 * V3d(1, 2, -3) - 6.0 * z).dot(z) < 0) {
        EXPECT_NEAR(other, many, 2e-3);
      }
    }
  }
}

TEST(OcclusionInvariance, WhateverAFrameHoldsIsAShare) {
  for (uint64_t seed = 1; seed <= 12; ++seed) {
    const auto frame = RandomSoup(seed, 150, seed % 2 == 0);
    for (const OcclusionSettings& settings : AllSettings(4)) {
      SCOPED_TRACE(testing::Message() << "seed " << seed << ", fall-off " << int(settings.falloff));
      const auto occlusion = AmbientOcclusion::Create(frame, settings, 2);
      ASSERT_TRUE(occlusion.ok());
      std::vector<double> expected;
      for (uint32_t i = 0; i < frame->triangles.size(); ++i) {
        expected.push_back(occlusion->At(i, 0.3, 0.3));
        ASSERT_GE(expected.back(), 0);
        ASSERT_LE(expected.back(), 1);
      }
      ForEachTarget([&] {
        for (uint32_t i = 0; i < frame->triangles.size(); ++i) {
          ASSERT_EQ(occlusion->At(i, 0.3, 0.3), expected[i]) << i;
        }
      });
    }
  }
}

}  // namespace
}  // namespace shutterline::engine::invariance_test
