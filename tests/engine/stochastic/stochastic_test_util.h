#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>

#include "tests/support/frame_scene_builder.h"
#include "tests/support/render_tiles.h"
#include "worker/engine/stochastic/stochastic_integrator.h"

namespace shutterline::engine {

inline std::unique_ptr<TileIntegrator> MakeStochastic(const std::shared_ptr<const FrameScene>& frame, int spp,
                                                      uint64_t seed = 0, int number = 0) {
  RenderSettings settings;
  settings.width = frame->view.width;
  settings.height = frame->view.height;
  settings.integrator = IntegratorKind::kStochastic;
  settings.spp = spp;
  settings.seed = seed;
  auto integrator = StochasticIntegrator::Create(frame, number, settings, 1);
  EXPECT_TRUE(integrator.ok()) << integrator.status();
  return *std::move(integrator);
}

struct Estimate {
  double mean = 0, standard_error = 0;
};

/// A channel of a pixel over independent seeds.
inline Estimate EstimatePixel(const std::shared_ptr<const FrameScene>& frame, int x, int y, int spp,
                              int channel = 3, int seeds = 64) {
  double sum = 0, squares = 0;
  for (int seed = 0; seed < seeds; ++seed) {
    const double value =
        RenderRect(*MakeStochastic(frame, spp, uint64_t(seed)), {x, y, 1, 1}).At(0, 0)[channel];
    sum += value;
    squares += value * value;
  }
  const double mean = sum / seeds;
  const double variance = std::max(0.0, squares / seeds - mean * mean) * seeds / (seeds - 1);
  return {mean, std::sqrt(variance / seeds)};
}

/// The mean over seeds lies within four standard errors of `truth`. `slack` is for what single precision does
/// to an edge, and for estimates that have no variance.
inline void ExpectCoverage(const std::shared_ptr<const FrameScene>& frame, int x, int y, double truth,
                           int spp = 256, double slack = 3e-5) {
  const Estimate estimate = EstimatePixel(frame, x, y, spp);
  EXPECT_NEAR(estimate.mean, truth, 4 * estimate.standard_error + slack) << spp << " spp";
  EXPECT_LT(estimate.standard_error, 0.1 / std::sqrt(double(spp))) << "too noisy to show anything";
}

/// Triangles of all sizes that move in all ways, some through the eye, with shading that varies for some.
inline std::shared_ptr<const FrameScene> RandomFrame(uint32_t seed, int triangles, int side,
                                                     bool perspective = true) {
  std::mt19937 random(seed);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  FrameSceneBuilder builder(perspective ? PerspectiveView(side, side)
                                        : OrthographicView(side, side, 1, 0.1, 20));
  for (int i = 0; i < triangles; ++i) {
    const double size = std::exp(uniform(-3, 0.7));
    const V3d center(uniform(-2, 2), uniform(-2, 2), uniform(-8, -0.3));
    const V3d motion(uniform(-1, 1), uniform(-1, 1), uniform(-1, 3));
    std::array<V3d, 3> open, close;
    for (size_t k = 0; k < 3; ++k) {
      const auto offset = [&] { return V3d(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)) * size; };
      open[k] = center + offset();
      close[k] = i % 4 == 0 ? open[k] : i % 4 == 1 ? open[k] + motion : center + motion + offset();
    }
    FlatLook look;
    look.color = V3f(float(uniform(0, 1)), float(uniform(0, 1)), float(uniform(0, 1)));
    look.double_sided = i % 3 != 0;
    if (i % 5 == 0) look.vertex_colors = {{1, 0, 0, 1}, {0, 1, 0, 1}, {0, 0, 1, 1}};
    builder.AddViewTriangle(open, close, look);
  }
  return builder.Build();
}

}  // namespace shutterline::engine
