#include "worker/engine/shading/reflect.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "worker/engine/shading/studio.h"

namespace shutterline::engine {
namespace {

/// Faces +z, seen at an angle.
Surface Facing(double n_dot_v) {
  Surface surface;
  surface.to_camera = {std::sqrt(1 - n_dot_v * n_dot_v), 0, n_dot_v};
  return surface;
}

Lighting EvenSky(const V3d& radiance) {
  Lighting lighting;
  lighting.ambient = radiance;
  return lighting;
}

/// Hard case 40: what is white, matte or metal, shows an even sky's radiance, whatever else it is.
TEST(Reflect, FurnaceOfWhiteSurfacesIsExactlyOne) {
  for (uint32_t seed = 1; seed <= 64; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform;
    Surface surface = Facing(0.01 + 0.99 * uniform(random));
    surface.roughness = uniform(random);
    if (seed % 2 == 0) {
      surface.metallic = 1;
      surface.f0 = V3d(1);
    } else {
      surface.f0 = V3d(0.2 * uniform(random));
    }
    EXPECT_EQ(V3f(Reflect({}, EvenSky(V3d(1)), surface)), V3f(1)) << "seed " << seed;
  }
}

TEST(Reflect, NothingReflectsMoreThanItReceives) {
  for (uint32_t seed = 1; seed <= 256; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform;
    Surface surface = Facing(0.01 + 0.99 * uniform(random));
    surface.roughness = uniform(random);
    surface.metallic = uniform(random);
    surface.base_color = {uniform(random), uniform(random), uniform(random)};
    const double dielectric = 0.16 * uniform(random);
    surface.f0 = V3d(dielectric) + surface.metallic * (surface.base_color - V3d(dielectric));
    const V3d radiance = Reflect({}, EvenSky(V3d(1)), surface);
    for (int c = 0; c < 3; ++c) {
      EXPECT_GE(radiance[c], 0) << "seed " << seed;
      EXPECT_LE(radiance[c], 1 + 1e-12) << "seed " << seed;
    }
  }
}

FrameLight Sun(const V3d& to_light, double lux) {
  FrameLight light;
  light.kind = PunctualLight::Kind::kDirectional;
  light.direction = -to_light;
  light.intensity = V3f(float(lux));
  return light;
}

TEST(Reflect, MatteSurfacesShowIrradianceOverPi) {
  Surface surface = Facing(1);
  surface.f0 = V3d(0);
  surface.f90 = 0;
  surface.base_color = {0.25, 0.5, 1};
  const FrameLight lights[] = {Sun(V3d(std::sin(1.0), 0, std::cos(1.0)), 10)};
  Lighting lighting;
  lighting.lights = lights;
  const V3d radiance = Reflect({}, lighting, surface);
  EXPECT_NEAR(radiance.z, 10 * std::cos(1.0) / M_PI, 1e-12);
  EXPECT_NEAR(radiance.x, radiance.z / 4, 1e-12);
}

TEST(Reflect, LightFromBehindDoesNothing) {
  const FrameLight lights[] = {Sun(V3d(0, 0, -1), 10)};
  Lighting lighting;
  lighting.lights = lights;
  EXPECT_EQ(Reflect({}, lighting, Facing(0.7)), V3d(0));
  // Nor does light that comes from behind the triangle, though the shading normal looks at it.
  Surface bent = Facing(0.7);
  bent.normal = V3d(1, 0, 0.2).normalized();
  const FrameLight behind[] = {Sun(V3d(1, 0, -0.1).normalized(), 10)};
  lighting.lights = behind;
  EXPECT_EQ(Reflect({}, lighting, bent), V3d(0));
}

/// A surface lit by suns spread evenly over the hemisphere is one under an even sky: the sum over lights and
/// the table agree. Rough ones, so that a few thousand suns suffice.
TEST(Reflect, ManySunsMakeASky) {
  constexpr int kPolar = 60, kAround = 120;
  std::vector<FrameLight> suns;
  for (int i = 0; i < kPolar; ++i) {
    const double z = (i + 0.5) / kPolar, sine = std::sqrt(1 - z * z);
    for (int j = 0; j < kAround; ++j) {
      const double around = 2 * M_PI * (j + 0.5) / kAround;
      suns.push_back(
          Sun(V3d(sine * std::cos(around), sine * std::sin(around), z), 2 * M_PI / (kPolar * kAround)));
    }
  }
  for (const double metallic : {0.0, 1.0}) {
    for (const double roughness : {0.6, 0.8, 1.0}) {
      for (const double n_dot_v : {0.4, 0.7, 1.0}) {
        Surface surface = Facing(n_dot_v);
        surface.roughness = roughness;
        surface.metallic = metallic;
        surface.base_color = V3d(0.8);
        surface.f0 = metallic > 0 ? V3d(0.8) : V3d(0.04);
        Lighting lit;
        lit.lights = suns;
        const double by_suns = Reflect({}, lit, surface).x;
        const double by_sky = Reflect({}, EvenSky(V3d(1)), surface).x;
        EXPECT_NEAR(by_suns, by_sky, 0.03 * by_sky)
            << "metallic " << metallic << ", roughness " << roughness << ", N·V " << n_dot_v;
      }
    }
  }
}

TEST(Reflect, MirrorsShowTheSkyInTheReflectedDirection) {
  Lighting lighting;
  lighting.sky = Studio();
  Surface surface = Facing(0.6);
  surface.metallic = 1;
  surface.f0 = V3d(1);
  surface.roughness = 0;
  const V3d reflected(-surface.to_camera.x, 0, surface.to_camera.z);
  EXPECT_NEAR(Reflect({}, lighting, surface).x, Studio()->Glossy(reflected, 0).x, 0.01);
  // The camera turns, the sky stays: the same view directions now look elsewhere in the world.
  FrameView turned;
  turned.world_axes = {V3d(0, 0, 1), V3d(0, 1, 0), V3d(-1, 0, 0)};
  const V3d in_world(reflected.z, reflected.y, -reflected.x);
  EXPECT_NEAR(Reflect(turned, lighting, surface).x, Studio()->Glossy(in_world, 0).x, 0.01);
}

}  // namespace
}  // namespace shutterline::engine
