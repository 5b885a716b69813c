#include "worker/engine/reference/instant_tracer.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/engine/reference/reference_test_util.h"

namespace shutterline::engine {
namespace {

std::unique_ptr<TileIntegrator> MakeShared(const std::shared_ptr<const FrameScene>& frame, int spp,
                                           uint64_t seed = 0, int threads = 1) {
  RenderSettings settings;
  settings.width = frame->view.width;
  settings.height = frame->view.height;
  settings.integrator = IntegratorKind::kReference;
  settings.reference_layout = ReferenceLayout::kSharedInstants;
  settings.spp = spp;
  settings.seed = seed;
  auto tracer = InstantTracer::Create(frame, 0, settings, threads);
  EXPECT_TRUE(tracer.ok()) << tracer.status();
  return tracer.ok() ? *std::move(tracer) : nullptr;
}

std::shared_ptr<const FrameScene> MovingFrame() {
  FrameSceneBuilder builder(PerspectiveView(48, 48));
  builder.AddRectangle(2.3, 3.1, 30.2, 25.7, 3, {.color = {0.9f, 0.2f, 0.1f}}, 11.4, 6.3);
  builder.AddRectangle(10, 5, 40, 20, 5, {.color = {0.1f, 0.2f, 0.7f}});
  builder.AddTriangle({{{5, 40, 2}, {30, 42, 3}, {20, 10, 1}}}, {{{15, 35, 2}, {40, 45, 2}, {22, 14, 4}}},
                      {.color = {0.2f, 0.8f, 0.3f},
                       .double_sided = true,
                       .vertex_colors = {{1, 0, 0, 1}, {0, 1, 0, 1}, {0, 0, 1, 1}}});
  return builder.Build();
}

TEST(InstantTracer, TilesAndThreadsDoNotMatter) {
  const auto frame = MovingFrame();
  const auto one = MakeShared(frame, 10);
  const Image whole = RenderTiles(*one, 48, 48, 48, 48);
  for (const Image& other : {RenderTiles(*one, 48, 48, 32, 32), RenderTiles(*one, 48, 48, 7, 5, 3),
                             RenderTiles(*MakeShared(frame, 10, 0, 4), 48, 48, 16, 16)}) {
    for (size_t i = 0; i < whole.values().size(); ++i) ASSERT_EQ(whole.values()[i], other.values()[i]) << i;
  }
}

TEST(InstantTracer, HasMoreInstantsThanEmbreeAllowsDevices) {
  const auto frame = MovingFrame();
  EXPECT_NE(MakeShared(frame, 1100), nullptr);
}

/// Means over many seeds agree with those of independent times, pixel by pixel.
TEST(InstantTracer, UnbiasedOverSeeds) {
  const auto frame = MovingFrame();
  constexpr int kSeeds = 48, kSpp = 16, kSide = 48;
  std::vector<double> sum(size_t(kSide * kSide) * 4), squares(sum.size()), truth(sum.size());
  for (int seed = 0; seed < kSeeds; ++seed) {
    const Image image = RenderTiles(*MakeShared(frame, kSpp, uint64_t(seed)), kSide, kSide);
    for (size_t i = 0; i < sum.size(); ++i) {
      sum[i] += double(image.values()[i]);
      squares[i] += double(image.values()[i]) * double(image.values()[i]);
    }
  }
  const Image reference = RenderTiles(*MakeTracer(frame, 4096, 99), kSide, kSide);
  double chi = 0;
  int count = 0;
  for (size_t i = 0; i < sum.size(); ++i) {
    const double mean = sum[i] / kSeeds;
    const double variance = std::max(0.0, squares[i] / kSeeds - mean * mean) / (kSeeds - 1);
    const double error = mean - double(reference.values()[i]);
    // Corners that a few of a thousand samples meet may have been missed by all.
    EXPECT_LT(std::abs(error), 6 * std::sqrt(variance) + 0.015) << "value " << i;
    if (variance < 1e-6) continue;
    chi += error * error / variance;
    ++count;
  }
  ASSERT_GT(count, 500);
  // One a value, if there is no bias; values of neighbours go together, so the margin is wide.
  EXPECT_LT(chi / count, 1.5);
}

/// Sharing instants costs no accuracy of pixels.
TEST(InstantTracer, ErrorIsThatOfTimesOfTheirOwn) {
  const auto frame = MovingFrame();
  const Image truth = RenderTiles(*MakeTracer(frame, 8192, 7), 48, 48);
  const auto error = [&](const TileIntegrator& integrator) {
    const Image image = RenderTiles(integrator, 48, 48);
    double sum = 0;
    for (size_t i = 0; i < image.values().size(); ++i) {
      sum += std::pow(double(image.values()[i]) - double(truth.values()[i]), 2);
    }
    return sum;
  };
  double shared = 0, own = 0;
  for (uint64_t seed = 0; seed < 8; ++seed) {
    shared += error(*MakeShared(frame, 32, seed));
    own += error(*MakeTracer(frame, 32, seed));
  }
  EXPECT_LT(std::sqrt(shared / own), 1.15);
}

TEST(InstantTracer, FitsDependsOnTreesThatAreNeeded) {
  FrameSceneBuilder still(PerspectiveView(48, 48));
  still.AddRectangle(10, 5, 40, 20, 5);
  EXPECT_TRUE(InstantTracer::Fits(*still.Build(), kMaxSpp));
  EXPECT_TRUE(InstantTracer::Fits(*MovingFrame(), 1024));
  EXPECT_FALSE(InstantTracer::Fits(*MovingFrame(), kMaxSpp));
}

}  // namespace
}  // namespace shutterline::engine
