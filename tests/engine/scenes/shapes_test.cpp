#include "tests/scenes/shapes.h"

#include <gtest/gtest.h>

#include <cmath>

namespace shutterline::scenes {
namespace {

/// Of a closed surface whose fronts look outwards: positive, by the divergence theorem.
double Volume(const Primitive& primitive) {
  double volume = 0;
  for (const auto& [a, b, c] : primitive.triangles) {
    const V3d p(primitive.positions[a]), q(primitive.positions[b]), r(primitive.positions[c]);
    volume += p.dot(q.cross(r)) / 6;
  }
  return volume;
}

/// Every normal is a unit vector on the front side of the triangles that use it.
void ExpectNormals(const Primitive& primitive) {
  ASSERT_EQ(primitive.normals.size(), primitive.positions.size());
  for (const auto& triangle : primitive.triangles) {
    const V3f& p = primitive.positions[triangle[0]];
    const V3f cross = (primitive.positions[triangle[1]] - p).cross(primitive.positions[triangle[2]] - p);
    for (const uint32_t corner : triangle) {
      EXPECT_NEAR(primitive.normals[corner].length(), 1, 1e-5);
      if (cross.length() > 1e-7f) {
        EXPECT_GT(primitive.normals[corner].dot(cross.normalized()), 0.5f);
      }
    }
  }
}

TEST(Shapes, Box) {
  Primitive box;
  AddBox(box, V3f(-1, 2, 0.5f), V3f(2, 4, 1));
  EXPECT_EQ(box.triangles.size(), 12u);
  EXPECT_NEAR(Volume(box), 3 * 2 * 0.5, 1e-6);
  ExpectNormals(box);
}

TEST(Shapes, RegularSolidsHaveTheirVolumes) {
  // By the radius of the sphere through their corners.
  const double g = (1 + std::sqrt(5.0)) / 2;
  const double icosahedron_edge = 2 / std::sqrt(g * std::sqrt(5.0));
  const std::pair<int, double> solids[] = {
      {4, 8 * std::sqrt(3.0) / 27},
      {6, 8 / std::pow(3.0, 1.5)},
      {8, 4.0 / 3},
      {20, 5 * (3 + std::sqrt(5.0)) / 12 * std::pow(icosahedron_edge, 3)}};
  for (const auto& [faces, volume] : solids) {
    Primitive solid;
    AddRegularSolid(solid, faces, 2);
    EXPECT_NEAR(Volume(solid), 8 * volume, 1e-4) << faces;
    ExpectNormals(solid);
  }
}

TEST(Shapes, RoundOnesApproachTheirVolumes) {
  Primitive sphere, torus;
  AddSphere(sphere, V3f(1, 2, 3), 2, 96, 48);
  EXPECT_NEAR(Volume(sphere), 4.0 / 3 * M_PI * 8, 0.1);
  ExpectNormals(sphere);
  AddTorus(torus, V3f(0), 3, 1, 96, 48);
  EXPECT_NEAR(Volume(torus), 2 * M_PI * M_PI * 3, 0.4);
  ExpectNormals(torus);
}

TEST(Shapes, TubesFaceOutwards) {
  for (const V3f& to : {V3f(0, 1, 0), V3f(0, -1, 0), V3f(0.3f, 0.2f, -0.5f)}) {
    Primitive tube;
    AddTube(tube, V3f(0), to, 0.2f, 0.1f, 16);
    EXPECT_EQ(tube.triangles.size(), 32u);
    for (size_t i = 0; i < tube.positions.size(); ++i) {
      const V3f axis = to.normalized();
      const V3f out = tube.positions[i] - axis * axis.dot(tube.positions[i]);
      EXPECT_GT(tube.normals[i].dot(out), 0);
    }
  }
}

TEST(Shapes, ColoursAreLinear) {
  EXPECT_EQ(Srgb(0xff0000), V3f(1, 0, 0));
  EXPECT_NEAR(Srgb(0x00bc00).y, 0.5029, 1e-4);
}

}  // namespace
}  // namespace shutterline::scenes
