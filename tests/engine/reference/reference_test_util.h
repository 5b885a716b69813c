#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "tests/support/frame_scene_builder.h"
#include "tests/support/render_tiles.h"
#include "worker/engine/reference/embree_tracer.h"

namespace shutterline::engine {

inline std::unique_ptr<EmbreeTracer> MakeTracer(const std::shared_ptr<const FrameScene>& frame, int spp,
                                                uint64_t seed = 0, int number = 0, int threads = 1) {
  RenderSettings settings;
  settings.width = frame->view.width;
  settings.height = frame->view.height;
  settings.integrator = IntegratorKind::kReference;
  settings.spp = spp;
  settings.seed = seed;
  auto tracer = EmbreeTracer::Create(frame, number, settings, threads);
  EXPECT_TRUE(tracer.ok()) << tracer.status();
  return *std::move(tracer);
}

struct Estimate {
  double mean = 0, standard_error = 0;
};

/// A pixel's alpha over independent seeds.
inline Estimate EstimateCoverage(const std::shared_ptr<const FrameScene>& frame, int x, int y, int spp = 256,
                                 int seeds = 32) {
  double sum = 0, squares = 0;
  for (int seed = 0; seed < seeds; ++seed) {
    const double alpha = RenderRect(*MakeTracer(frame, spp, uint64_t(seed)), {x, y, 1, 1}).At(0, 0)[3];
    sum += alpha;
    squares += alpha * alpha;
  }
  const double mean = sum / seeds;
  const double variance = std::max(0.0, squares / seeds - mean * mean) * seeds / (seeds - 1);
  return {mean, std::sqrt(variance / seeds)};
}

/// The mean over seeds lies within four standard errors of `truth`, and these are small. `slack` is for what
/// single precision does to a ray.
inline void ExpectCoverage(const std::shared_ptr<const FrameScene>& frame, int x, int y, double truth,
                           double slack = 1e-5) {
  const Estimate estimate = EstimateCoverage(frame, x, y);
  EXPECT_NEAR(estimate.mean, truth, 4 * estimate.standard_error + slack);
  EXPECT_LT(estimate.standard_error, 3e-3) << "too noisy to show anything";
}

}  // namespace shutterline::engine
