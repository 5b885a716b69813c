#include "worker/engine/shading/sky_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "worker/engine/shading/studio.h"

namespace shutterline::engine {
namespace {

V3d RandomDirection(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return V3d(normal(random), normal(random), normal(random)).normalized();
}

TEST(SkyMap, AnEvenSkyIsEvenExactly) {
  const auto sky = SkyMap::Uniform(V3d(1, 0.5, 3));
  std::mt19937 random(1);
  for (int i = 0; i < 100; ++i) {
    const V3d d = RandomDirection(random);
    EXPECT_EQ(sky->Diffuse(d), V3d(1, 0.5, 3));
    EXPECT_EQ(sky->Glossy(d, i / 99.0), V3d(1, 0.5, 3));
  }
}

/// Of radiance 2 + y, a matte surface sees 2 + 2/3 of its normal's y; a lobe around d sees 2 + c d.y, where c
/// is the lobe's mean cosine, one for a mirror.
TEST(SkyMap, ASkyThatBrightensUpwards) {
  const auto sky = SkyMap::Make([](const V3d& d) { return V3d(2 + d.y, 1, 2 + d.x); }, 256);
  for (uint32_t seed = 1; seed <= 64; ++seed) {
    std::mt19937 random(seed);
    const V3d d = RandomDirection(random);
    const V3d diffuse = sky->Diffuse(d);
    EXPECT_NEAR(diffuse.x, 2 + d.y * 2 / 3, 1e-3) << "seed " << seed;
    EXPECT_NEAR(diffuse.y, 1, 1e-3) << "seed " << seed;
    EXPECT_NEAR(diffuse.z, 2 + d.x * 2 / 3, 1e-3) << "seed " << seed;
    EXPECT_NEAR(sky->Glossy(d, 0).x, 2 + d.y, 2e-3) << "seed " << seed;
    double least = 1;
    for (const double roughness : {0.2, 0.45, 0.7, 1.0}) {
      const double seen = sky->Glossy(d, roughness).x;
      // The lobe is symmetric: what is seen is a multiple of d.y, the smaller the rougher.
      if (std::abs(d.y) < 0.2) continue;
      const double cosine = (seen - 2) / d.y;
      EXPECT_LT(cosine, least + 0.01) << "seed " << seed << ", roughness " << roughness;
      EXPECT_GT(cosine, 0.5) << "seed " << seed << ", roughness " << roughness;
      least = cosine;
    }
  }
}

TEST(SkyMap, DirectionsAreWhereTheyShouldBe) {
  // One bright quarter around +x: only what looks there sees it.
  const auto sky = SkyMap::Make([](const V3d& d) { return V3d(d.x > 0.7 ? 1 : 0); }, 256);
  EXPECT_EQ(sky->Glossy(V3d(1, 0, 0), 0).x, 1);
  for (const V3d& d : {V3d(-1, 0, 0), V3d(0, 1, 0), V3d(0, -1, 0), V3d(0, 0, 1), V3d(0, 0, -1)}) {
    EXPECT_EQ(sky->Glossy(d, 0).x, 0) << d;
    EXPECT_LT(sky->Diffuse(d).x, sky->Diffuse(V3d(1, 0, 0)).x) << d;
  }
}

TEST(SkyMap, PicturesLieAsOpenExrHasThem) {
  // Rows from above; the middle column towards +z, the left quarter towards +x.
  auto picture = std::make_shared<Environment>();
  picture->width = 64;
  picture->height = 32;
  for (int y = 0; y < 32; ++y) {
    for (int x = 0; x < 64; ++x) {
      picture->texels.emplace_back(std::abs(x - 16) < 4 ? 1 : 0, std::abs(x - 32) < 4 ? 1 : 0, y < 4 ? 1 : 0);
    }
  }
  const auto sky = SkyMap::Of(picture);
  EXPECT_EQ(SkyMap::Of(picture), sky);
  EXPECT_EQ(sky->Glossy(V3d(1, 0, 0), 0).x, 1);
  EXPECT_EQ(sky->Glossy(V3d(0, 0, 1), 0).y, 1);
  EXPECT_EQ(sky->Glossy(V3d(0, 1, 0), 0).z, 1);
  EXPECT_EQ(sky->Glossy(V3d(0, 0, -1), 0), V3d(0));
}

TEST(SkyMap, FilteringKeepsWhatComesFromEverywhere) {
  // The mean over all directions is the same, however rough the surface.
  const auto sky = Studio();
  std::mt19937 random(5);
  constexpr int kDirections = 20000;
  double means[3] = {0, 0, 0};
  const double roughnesses[3] = {0, 0.45, 1};
  for (int i = 0; i < kDirections; ++i) {
    const V3d d = RandomDirection(random);
    for (int k = 0; k < 3; ++k) means[k] += sky->Glossy(d, roughnesses[k]).x / kDirections;
  }
  EXPECT_NEAR(means[1] / means[0], 1, 0.03);
  EXPECT_NEAR(means[2] / means[0], 1, 0.03);
}

TEST(Studio, WhiteMatteSurfacesAreNeitherBlackNorBurntOut) {
  std::mt19937 random(7);
  for (int i = 0; i < 1000; ++i) {
    const double light = Studio()->Diffuse(RandomDirection(random)).y;
    EXPECT_GT(light, 0.05);
    EXPECT_LT(light, 1.3);
  }
}

}  // namespace
}  // namespace shutterline::engine
