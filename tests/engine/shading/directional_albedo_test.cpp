#include "worker/engine/shading/directional_albedo.h"

#include <gtest/gtest.h>

#include <cmath>

#include "worker/engine/shading/ggx.h"

namespace shutterline::engine {
namespace {

/// ∫ D V F N·L over the hemisphere of light directions, by the midpoint rule in the light's angles: another
/// way than by half vectors.
double AlbedoByLightDirections(double n_dot_v, double alpha) {
  constexpr int kPolar = 800, kAround = 400;
  const V3d view(std::sqrt(1 - n_dot_v * n_dot_v), 0, n_dot_v);
  double sum = 0;
  for (int i = 0; i < kPolar; ++i) {
    const double polar = M_PI / 2 * (i + 0.5) / kPolar;
    for (int j = 0; j < kAround; ++j) {
      const double around = M_PI * (j + 0.5) / kAround;  // Symmetric: half the circle.
      const V3d light(std::sin(polar) * std::cos(around), std::sin(polar) * std::sin(around),
                      std::cos(polar));
      const V3d half = (view + light).normalized();
      sum += GgxDistribution(half.z, alpha) * SmithVisibility(n_dot_v, light.z, alpha) * light.z *
             std::sin(polar);
    }
  }
  return sum * (M_PI / 2 / kPolar) * (2 * M_PI / kAround);
}

TEST(DirectionalAlbedo, IsTheIntegralOfTheModel) {
  for (const double roughness : {0.4, 0.6, 0.8, 1.0}) {
    for (const double n_dot_v : {0.1, 0.35, 0.7, 1.0}) {
      const DirectionalAlbedo albedo = GgxDirectionalAlbedo(n_dot_v, roughness);
      EXPECT_NEAR(albedo.scale + albedo.bias, AlbedoByLightDirections(n_dot_v, roughness * roughness), 0.01)
          << "roughness " << roughness << ", N·V " << n_dot_v;
    }
  }
}

TEST(DirectionalAlbedo, NeverExceedsOneAndMirrorsKeepAll) {
  for (int r = 0; r <= 40; ++r) {
    for (int v = 0; v <= 40; ++v) {
      const DirectionalAlbedo albedo = GgxDirectionalAlbedo(v / 40.0, r / 40.0);
      EXPECT_GE(albedo.scale, 0);
      EXPECT_GE(albedo.bias, 0);
      EXPECT_LE(albedo.scale + albedo.bias, 1.001) << v << ", " << r;
    }
  }
  const DirectionalAlbedo mirror = GgxDirectionalAlbedo(0.5, 0);
  EXPECT_NEAR(mirror.scale + mirror.bias, 1, 2e-3);
  EXPECT_NEAR(mirror.bias, std::pow(0.5, 5), 2e-3);  // Schlick's share at this angle.
}

TEST(Ggx, FacetsCoverTheirSurfaceOnce) {
  for (const double alpha : {0.05, 0.3, 1.0}) {
    double sum = 0;
    constexpr int kSteps = 200000;
    for (int i = 0; i < kSteps; ++i) {
      const double polar = M_PI / 2 * (i + 0.5) / kSteps;
      sum += GgxDistribution(std::cos(polar), alpha) * std::cos(polar) * std::sin(polar);
    }
    EXPECT_NEAR(sum * M_PI / 2 / kSteps * 2 * M_PI, 1, 1e-4) << alpha;
  }
}

}  // namespace
}  // namespace shutterline::engine
