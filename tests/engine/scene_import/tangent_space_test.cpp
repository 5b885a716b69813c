#include "worker/engine/scene/tangent_space.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <random>

namespace shutterline::engine::tangent_space_test {
namespace {

/// A quad in the plane z = 0 with its front to +z, and texture coordinates by corner: bottom left, bottom
/// right, top right, top left.
MeshPrimitive Quad(const std::array<V2f, 4>& uv) {
  MeshPrimitive quad;
  quad.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  quad.normals.assign(4, V3f(0, 0, 1));
  quad.texcoords[0].assign(uv.begin(), uv.end());
  quad.triangles = {{0, 1, 2}, {0, 2, 3}};
  return quad;
}

void ExpectAll(const std::vector<V4f>& tangents, const V4f& expected) {
  for (const V4f& tangent : tangents) {
    for (int i = 0; i < 4; ++i) EXPECT_NEAR(tangent[i], expected[i], 1e-6);
  }
}

TEST(TangentSpace, FollowsThePictureOnAQuad) {
  // The picture upright: u to the right, v down. The bitangent, cross(normal, tangent), is up.
  const MeshPrimitive upright = Quad({V2f(0, 1), {1, 1}, {1, 0}, {0, 0}});
  EXPECT_EQ(MakeTangents(upright, 0).size(), 6u);
  ExpectAll(MakeTangents(upright, 0), V4f(1, 0, 0, 1));
  // Mirrored left to right: u to the left; up stays up, so the sign turns.
  ExpectAll(MakeTangents(Quad({V2f(1, 1), {0, 1}, {0, 0}, {1, 0}}), 0), V4f(-1, 0, 0, -1));
  // Upside down: up in the picture is down.
  ExpectAll(MakeTangents(Quad({V2f(0, 0), {1, 0}, {1, 1}, {0, 1}}), 0), V4f(1, 0, 0, -1));
  // A quarter turn: u grows upwards.
  ExpectAll(MakeTangents(Quad({V2f(0, 0), {0, 1}, {1, 1}, {1, 0}}), 0), V4f(0, 1, 0, 1));
  // Scaled and sheared: growing u at equal v is a direction of its own. Here u = 2 x + 2 y, v = -3 y.
  ExpectAll(MakeTangents(Quad({V2f(0, 0), {2, 0}, {4, -3}, {2, -3}}), 0), V4f(1, 0, 0, 1));
  const auto half = float(std::sqrt(0.5));
  // u = x, v = -x - y: at equal v, y falls as x grows.
  ExpectAll(MakeTangents(Quad({V2f(0, 0), {1, -1}, {1, -2}, {0, -1}}), 0), V4f(half, -half, 0, 1));
}

TEST(TangentSpace, ReadsTheSetThatItIsTold) {
  MeshPrimitive quad = Quad({V2f(0, 1), {1, 1}, {1, 0}, {0, 0}});
  quad.texcoords[1] = {{0, 0}, {0, 1}, {1, 1}, {1, 0}};
  ExpectAll(MakeTangents(quad, 1), V4f(0, 1, 0, 1));
}

TEST(TangentSpace, LiesInTheNormalsPlane) {
  MeshPrimitive quad = Quad({V2f(0, 1), {1, 1}, {1, 0}, {0, 0}});
  quad.normals.assign(4, V3f(0.6f, 0, 0.8f));
  ExpectAll(MakeTangents(quad, 0), V4f(0.8f, 0, -0.6f, 1));
}

TEST(TangentSpace, WeighsTrianglesByTheirAngles) {
  // Three triangles about the origin with one normal; u is along a direction of its own in each, so that the
  // tangent there is the mean of these, weighted by angles of 90, 45 and 45 degrees.
  MeshPrimitive fan;
  const std::array<V3f, 4> rim = {V3f(1, 0, 0), {0, 1, 0}, {-1, 1, 0}, {-1, 0, 0}};
  const std::array<double, 3> directions = {0.1, 0.5, -0.7};
  const std::array<double, 3> angles = {0.5, 0.25, 0.25};
  V2d mean(0);
  for (size_t i = 0; i < 3; ++i) {
    const double c = std::cos(directions[i]), s = std::sin(directions[i]);
    mean += angles[i] * V2d(c, s);
    for (const V3f& p : {V3f(0, 0, 0), rim[i], rim[i + 1]}) {
      fan.positions.push_back(p);
      // u grows along (c, s), v falls along (-s, c).
      fan.texcoords[0].emplace_back(float(c * double(p.x) + s * double(p.y)),
                                    float(s * double(p.x) - c * double(p.y)));
    }
    const auto first = uint32_t(3 * i);
    fan.triangles.push_back({first, first + 1, first + 2});
  }
  fan.normals.assign(9, V3f(0, 0, 1));
  const std::vector<V4f> tangents = MakeTangents(fan, 0);
  mean.normalize();
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(double(tangents[3 * i].x), mean.x, 1e-6);
    EXPECT_NEAR(double(tangents[3 * i].y), mean.y, 1e-6);
    EXPECT_EQ(tangents[3 * i].w, 1);
    // The rim's coordinates differ from triangle to triangle, so each keeps its own.
    EXPECT_NEAR(double(tangents[3 * i + 1].y), std::sin(directions[i]), 1e-6);
  }
}

TEST(TangentSpace, MirroredNeighboursStayApart) {
  // Two quads side by side whose pictures meet as mirror images; they share the vertices of the seam.
  MeshPrimitive wings;
  wings.positions = {{-1, 0, 0}, {0, 0, 0}, {1, 0, 0}, {-1, 1, 0}, {0, 1, 0}, {1, 1, 0}};
  wings.normals.assign(6, V3f(0, 0, 1));
  wings.texcoords[0] = {{1, 1}, {0, 1}, {1, 1}, {1, 0}, {0, 0}, {1, 0}};
  wings.triangles = {{0, 1, 4}, {0, 4, 3}, {1, 2, 5}, {1, 5, 4}};
  const std::vector<V4f> tangents = MakeTangents(wings, 0);
  ExpectAll({tangents.begin(), tangents.begin() + 6}, V4f(-1, 0, 0, -1));
  ExpectAll({tangents.begin() + 6, tangents.end()}, V4f(1, 0, 0, 1));
}

/// A bumpy grid with smooth normals; coordinates are mirrored in its middle. Some triangles are degenerate in
/// space or in the texture.
MeshPrimitive BumpyGrid(uint32_t seed) {
  constexpr uint32_t kSide = 9;
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(-0.3f, 0.3f);
  MeshPrimitive grid;
  for (uint32_t y = 0; y < kSide; ++y) {
    for (uint32_t x = 0; x < kSide; ++x) {
      grid.positions.emplace_back(float(x) + uniform(random), float(y) + uniform(random), uniform(random));
      grid.normals.push_back(V3f(uniform(random), uniform(random), 1).normalized());
      const float u = std::abs(float(x) - 4);
      grid.texcoords[0].emplace_back(u + 0.3f * uniform(random), -float(y) + 0.3f * uniform(random));
    }
  }
  for (uint32_t y = 0; y + 1 < kSide; ++y) {
    for (uint32_t x = 0; x + 1 < kSide; ++x) {
      const uint32_t v = y * kSide + x;
      grid.triangles.push_back({v, v + 1, v + kSide + 1});
      grid.triangles.push_back({v, v + kSide + 1, v + kSide});
    }
  }
  grid.texcoords[0][3 * kSide + 2] = grid.texcoords[0][3 * kSide + 1];
  grid.positions[0].z = 0;
  grid.positions[5 * kSide + 6] = grid.positions[5 * kSide + 5];
  return grid;
}

TEST(TangentSpace, DoesNotDependOnWhatVerticesAreShared) {
  for (uint32_t seed = 0; seed < 20; ++seed) {
    const MeshPrimitive welded = BumpyGrid(seed);
    MeshPrimitive loose;
    for (const auto& triangle : welded.triangles) {
      const auto first = uint32_t(loose.positions.size());
      for (const uint32_t v : triangle) {
        loose.positions.push_back(welded.positions[v]);
        loose.normals.push_back(welded.normals[v]);
        loose.texcoords[0].push_back(welded.texcoords[0][v]);
      }
      loose.triangles.push_back({first, first + 1, first + 2});
    }
    loose.positions[0].z = -0.0f;  // And 0 are one place.
    EXPECT_EQ(MakeTangents(welded, 0), MakeTangents(loose, 0)) << "seed " << seed;
  }
}

TEST(TangentSpace, IsAlwaysUnitAndAcrossTheNormal) {
  for (uint32_t seed = 0; seed < 20; ++seed) {
    MeshPrimitive grid = BumpyGrid(seed);
    for (const bool without_normals : {false, true}) {
      if (without_normals) grid.normals.clear();
      const std::vector<V4f> tangents = MakeTangents(grid, 0);
      ASSERT_EQ(tangents.size(), 3 * grid.triangles.size());
      for (size_t i = 0; i < tangents.size(); ++i) {
        const auto& triangle = grid.triangles[i / 3];
        const V3d tangent(double(tangents[i].x), double(tangents[i].y), double(tangents[i].z));
        EXPECT_NEAR(tangent.length(), 1, 1e-6);
        EXPECT_EQ(std::abs(tangents[i].w), 1);
        const V3d a(grid.positions[triangle[0]]), b(grid.positions[triangle[1]]),
            c(grid.positions[triangle[2]]);
        const V3d normal =
            without_normals ? (b - a).cross(c - a).normalized() : V3d(grid.normals[triangle[i % 3]]);
        EXPECT_NEAR(tangent.dot(normal), 0, 1e-6) << "seed " << seed << ", corner " << i;
      }
    }
  }
}

TEST(TangentSpace, WithoutNormalsTrianglesAreByThemselves) {
  // A ridge: two faces of one picture, bent at right angles.
  MeshPrimitive ridge;
  ridge.positions = {{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {0, -1, 0}};
  ridge.texcoords[0] = {{0, 0}, {0, 1}, {1, 0}, {-1, 0}};
  ridge.triangles = {{0, 1, 2}, {0, 3, 1}};
  const std::vector<V4f> tangents = MakeTangents(ridge, 0);
  ExpectAll({tangents.begin(), tangents.begin() + 3}, V4f(1, 0, 0, 1));
  ExpectAll({tangents.begin() + 3, tangents.end()}, V4f(0, 1, 0, 1));
}

TEST(TangentSpace, TrianglesWithoutAreaInTheTextureTakeTheirNeighbours) {
  MeshPrimitive quad = Quad({V2f(1, 1), {0, 1}, {0, 0}, {1, 0}});  // Mirrored.
  // A sliver at the top edge, whose third corner has the coordinate of its second.
  quad.positions.push_back({0.5f, 1.5f, 0});
  quad.normals.emplace_back(0.f, 0.f, 1.f);
  quad.texcoords[0].push_back(quad.texcoords[0][3]);
  quad.triangles.push_back({3, 2, 4});
  const std::vector<V4f> tangents = MakeTangents(quad, 0);
  ExpectAll({tangents.begin() + 6, tangents.begin() + 8}, V4f(-1, 0, 0, -1));
  // The corner that nobody shares has some direction in the plane, and the sign of the others.
  EXPECT_EQ(tangents[8].w, -1);
  EXPECT_EQ(tangents[8].z, 0);
  EXPECT_NEAR(std::hypot(tangents[8].x, tangents[8].y), 1, 1e-6);
}

TEST(TangentSpace, ScaleChangesNothing) {
  MeshPrimitive grid = BumpyGrid(3);
  const std::vector<V4f> tangents = MakeTangents(grid, 0);
  for (V3f& p : grid.positions) p *= std::ldexp(1.f, 60);
  for (V2f& uv : grid.texcoords[0]) uv *= std::ldexp(1.f, -40);
  EXPECT_EQ(MakeTangents(grid, 0), tangents);
}

}  // namespace
}  // namespace shutterline::engine::tangent_space_test
