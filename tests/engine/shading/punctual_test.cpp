#include "worker/engine/shading/punctual.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace shutterline::engine {
namespace {

FrameLight Light(PunctualLight::Kind kind) {
  FrameLight light;
  light.kind = kind;
  light.position = {1, 2, 3};
  light.direction = {0, -1, 0};
  light.intensity = {12, 24, 6};
  return light;
}

TEST(Punctual, DirectionalLightIsTheSameEverywhere) {
  const FrameLight light = Light(PunctualLight::Kind::kDirectional);
  for (const V3d& position : {V3d(0), V3d(1, 2, 3), V3d(1e9, 0, -4)}) {
    const auto incidence = IncidenceAt(light, position);
    ASSERT_TRUE(incidence);
    EXPECT_EQ(incidence->to_light, V3d(0, 1, 0));
    EXPECT_EQ(incidence->irradiance, V3d(12, 24, 6));
    EXPECT_TRUE(std::isinf(incidence->distance));
  }
}

TEST(Punctual, PointLightFallsOffWithTheSquare) {
  const FrameLight light = Light(PunctualLight::Kind::kPoint);
  const auto incidence = IncidenceAt(light, V3d(1, 2, 1));
  ASSERT_TRUE(incidence);
  EXPECT_EQ(incidence->to_light, V3d(0, 0, 1));
  EXPECT_DOUBLE_EQ(incidence->distance, 2);
  EXPECT_DOUBLE_EQ(incidence->irradiance.x, 3);
  EXPECT_FALSE(IncidenceAt(light, light.position));
}

TEST(Punctual, RangeFadesToNothing) {
  FrameLight light = Light(PunctualLight::Kind::kPoint);
  light.range = 4;
  EXPECT_DOUBLE_EQ(IncidenceAt(light, V3d(1, 2, 1))->irradiance.x, 3 * (1 - 1 / 16.0));
  EXPECT_FALSE(IncidenceAt(light, V3d(1, 2, -1)));
  EXPECT_FALSE(IncidenceAt(light, V3d(1, 2, -9)));
}

TEST(Punctual, SpotsLightTheirCone) {
  FrameLight light = Light(PunctualLight::Kind::kSpot);
  light.cos_inner = std::cos(0.2);
  light.cos_outer = std::cos(0.5);
  const auto at = [&](double angle) {
    return IncidenceAt(light, light.position + 2.0 * V3d(std::sin(angle), -std::cos(angle), 0));
  };
  EXPECT_NEAR(at(0)->irradiance.x, 3, 1e-12);
  EXPECT_NEAR(at(0.19)->irradiance.x, 3, 1e-12);
  EXPECT_FALSE(at(0.51));
  EXPECT_FALSE(at(3));
  const double part = (std::cos(0.35) - std::cos(0.5)) / (std::cos(0.2) - std::cos(0.5));
  EXPECT_NEAR(at(0.35)->irradiance.x, 3 * part * part, 1e-9);
}

}  // namespace
}  // namespace shutterline::engine
