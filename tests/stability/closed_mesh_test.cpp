// Closed moving meshes: their triangles cover what they enclose once, with no crack and no double cover.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "tests/stability/hard_case.h"
#include "tests/support/rounds.h"

namespace shutterline::engine::hard_case::closed_mesh_test {
namespace {

constexpr PatternKind kAllPatterns[] = {PatternKind::k1h1v, PatternKind::k2h2v,   PatternKind::k4h4v,
                                        PatternKind::k8h8v, PatternKind::k16h16v, PatternKind::kRgls};

/// A closed surface: a grid on the sphere whose vertices are moved at random.
struct ClosedMesh {
  std::vector<V3d> open, close;
  std::vector<std::array<uint32_t, 3>> triangles;
};

ClosedMesh RandomClosedMesh(uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(-1, 1);
  ClosedMesh mesh;
  // A grid on the sphere: `rings` rows of `sides` vertices and two poles.
  const int rings = 3 + int(random() % 6);
  const int sides = 3 + int(random() % 9);
  const V3d center(unit(random), unit(random), -6 + unit(random));
  const V3d travel(2 * unit(random), 2 * unit(random), 2 * unit(random));
  const auto add = [&](const V3d& direction) {
    const V3d p = center + direction * (1.2 + 0.4 * unit(random));
    mesh.open.push_back(p);
    mesh.close.push_back(p + travel + V3d(unit(random), unit(random), unit(random)) * 0.5);
  };
  add(V3d(0, 1, 0));
  for (int r = 1; r <= rings; ++r) {
    for (int s = 0; s < sides; ++s) {
      const double theta = M_PI * r / (rings + 1);
      const double phi = 2 * M_PI * s / sides;
      add(V3d(std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi)));
    }
  }
  add(V3d(0, -1, 0));
  const auto at = [&](int r, int s) { return uint32_t(1 + (r - 1) * sides + s % sides); };
  for (int s = 0; s < sides; ++s) {
    mesh.triangles.push_back({0, at(1, s + 1), at(1, s)});
    for (int r = 1; r < rings; ++r) {
      mesh.triangles.push_back({at(r, s), at(r, s + 1), at(r + 1, s)});
      mesh.triangles.push_back({at(r, s + 1), at(r + 1, s + 1), at(r + 1, s)});
    }
    mesh.triangles.push_back({uint32_t(mesh.open.size() - 1), at(rings, s), at(rings, s + 1)});
  }
  return mesh;
}

using ClosedMeshes = EachResolver;
INSTANTIATE_TEST_SUITE_P(Resolvers, ClosedMeshes, testing::Values(ResolverKind::kSlice, ResolverKind::kPaper),
                         ResolverName);

TEST_P(ClosedMeshes, Row21ClosedMeshCoversExactly) {
  // A closed mesh that surrounds the camera leaves no background: not one unit of weight is missing. Every
  // third mesh is also torn apart into separate vertices in random order, as glTF files have at seams.
  for (uint64_t seed = 1; seed <= uint64_t(Rounds(32)); ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> unit(-1, 1);
    ClosedMesh mesh = RandomClosedMesh(seed);
    // Blow it up around the camera.
    V3d middle(0, 0, 0);
    for (const V3d& p : mesh.open) middle += p / double(mesh.open.size());
    for (size_t i = 0; i < mesh.open.size(); ++i) {
      const V3d out = (mesh.open[i] - middle).normalized();
      mesh.open[i] = out * (20 + 2 * unit(random));
      mesh.close[i] = out * (20 + 2 * unit(random)) + V3d(unit(random), unit(random), unit(random));
    }
    FrameSceneBuilder builder(PerspectiveView(64, 64, 1.0, 0.01));
    if (seed % 3 == 0) {
      std::shuffle(mesh.triangles.begin(), mesh.triangles.end(), random);
      for (auto triangle : mesh.triangles) {
        std::rotate(triangle.begin(), triangle.begin() + int(random() % 3), triangle.end());
        builder.AddViewMesh({mesh.open[triangle[0]], mesh.open[triangle[1]], mesh.open[triangle[2]]},
                            {mesh.close[triangle[0]], mesh.close[triangle[1]], mesh.close[triangle[2]]},
                            {{0, 1, 2}});
      }
    } else {
      builder.AddViewMesh(mesh.open, mesh.close, mesh.triangles);
    }
    const auto frame = builder.Build();
    for (const PatternKind pattern : kAllPatterns) {
      if (pattern == PatternKind::k16h16v && seed % 4 != 0) continue;  // Half of all the lines.
      const ResolvedTile tile(*frame, {16, 16, 32, 32}, With(pattern, 5));
      for (int y = 0; y < 32; ++y) {
        for (int x = 0; x < 32; ++x) {
          ASSERT_EQ(tile.Covered(x, y), tile.total()) << ToString(pattern) << " pixel " << x << ", " << y;
        }
      }
    }
  }
}

TEST_P(ClosedMeshes, Row21NoDoubleCover) {
  // The same meshes seen from outside: with their back sides culled or not, coverage is the silhouette's
  // and never exceeds one; sums are integers, so this is exact.
  for (uint64_t seed = 1; seed <= uint64_t(Rounds(16)); ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    const ClosedMesh mesh = RandomClosedMesh(seed);
    FrameSceneBuilder builder(PerspectiveView(64, 64, 0.8, 0.01));
    builder.AddViewMesh(mesh.open, mesh.close, mesh.triangles);
    const auto frame = builder.Build();
    const ResolvedTile tile(*frame, {16, 16, 32, 32}, With(PatternKind::kRgls, 8));
    uint64_t covered = 0;
    for (int y = 0; y < 32; ++y) {
      for (int x = 0; x < 32; ++x) {
        ASSERT_LE(tile.Covered(x, y), tile.total());
        covered += tile.Covered(x, y);
      }
    }
    EXPECT_GT(covered, 0u);
  }
}

}  // namespace
}  // namespace shutterline::engine::hard_case::closed_mesh_test
