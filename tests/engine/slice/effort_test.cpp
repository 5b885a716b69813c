// How finely tiles are sampled: by an error that is aimed at, by motion, or as said.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <memory>
#include <numeric>
#include <random>
#include <vector>

#include "common/math/tolerance.h"
#include "tests/support/frame_scene_builder.h"
#include "tests/support/random_soup.h"
#include "worker/engine/slice/resolver_slice.h"

namespace shutterline::engine::effort_test {
namespace {

constexpr TileRect kTile{0, 0, 32, 32};

struct Rendered {
  std::vector<std::array<double, 4>> pixels;  // Divided by the total.
  double samples = 0;                         // A pixel.
  int64_t lines = 0;
};

V3f ColorOf(uint32_t triangle) {
  return {float(triangle % 3) / 2, float(triangle % 5) / 4, float(triangle % 7) / 6};
}

Rendered Render(const FrameScene& frame, const RenderSettings& settings, bool can_guess = true) {
  std::vector<PrimitiveTraits> traits;
  for (const FramePrimitive& primitive : frame.primitives) {
    traits.push_back({.cull_back = !primitive.material->double_sided});
  }
  std::vector<uint32_t> candidates(frame.triangles.size());
  std::iota(candidates.begin(), candidates.end(), 0u);
  const auto shade = [](uint32_t triangle) {
    const V3f color = ColorOf(triangle);
    ColorNodes nodes;
    nodes.corners = {color, color, color};
    return nodes;
  };
  ColorFilm film = can_guess ? ColorFilm(shade, ColorOf) : ColorFilm(shade);
  PairWeights weights;
  RenderStats stats;
  Rendered rendered;
  ResolverSlice(settings).Resolve({frame, traits, kTile, candidates}, weights, &film, stats);
  rendered.pixels = film.sums();
  for (auto& pixel : rendered.pixels) {
    for (double& value : pixel) value /= double(weights.total());
  }
  rendered.samples = double(weights.total()) / double(kSubpixelsPerPixel);
  rendered.lines = stats.lines;
  return rendered;
}

double Rmse(const Rendered& a, const Rendered& b) {
  double sum = 0;
  for (size_t i = 0; i < a.pixels.size(); ++i) {
    for (size_t c = 0; c < 3; ++c) sum += std::pow(a.pixels[i][c] - b.pixels[i][c], 2);
  }
  return std::sqrt(sum / (3 * double(a.pixels.size())));
}

RenderSettings Target(double error) {
  RenderSettings settings;
  settings.target_error = error;
  return settings;
}

RenderSettings Pinned(PatternKind pattern, int instants) {
  RenderSettings settings;
  settings.pattern = pattern;
  settings.time_samples = instants;
  return settings;
}

TEST(Effort, ErrorsComeOutNearWhatIsAimedAt) {
  // Within a factor of two over many tiles, which mix what moves and what stands still: each estimate is that
  // of a few samples.
  for (const double target : {0.02, 0.005}) {
    double square_sum = 0;
    double worst = 0;
    constexpr int kSeeds = 24;
    for (uint64_t seed = 1; seed <= kSeeds; ++seed) {
      const auto frame = RandomSoup(seed, 40, seed % 3 == 0);
      const Rendered truth = Render(*frame, Pinned(PatternKind::k8h8v, 128));
      const double error = Rmse(Render(*frame, Target(target)), truth);
      square_sum += error * error;
      worst = std::max(worst, error);
    }
    EXPECT_LT(std::sqrt(square_sum / kSeeds), 2 * target) << target;
    EXPECT_GT(std::sqrt(square_sum / kSeeds), 0.1 * target) << target << ": more was done than was asked for";
    EXPECT_LT(worst, 4 * target) << target;
  }
}

TEST(Effort, ASmallerErrorTakesMoreSamples) {
  double before = 0;
  for (const double target : {0.1, 0.03, 0.01, 0.003, 0.001}) {
    double samples = 0;
    for (uint64_t seed = 1; seed <= 8; ++seed) {
      samples += Render(*RandomSoup(seed, 40), Target(target)).samples;
    }
    EXPECT_GT(samples, 1.2 * before) << target;
    before = samples;
  }
}

/// A white square turned by an angle that no line has, over the middle of the tile.
std::shared_ptr<const FrameScene> Square(double motion) {
  FrameSceneBuilder builder(OrthographicView(32, 32));
  const auto corner = [](double turn, double x) {
    return Corner{16 + x + 9 * std::cos(0.4 + turn), 16 + 9 * std::sin(0.4 + turn), 1};
  };
  for (const std::array<double, 3>& turns : {std::array{0.0, 1.5708, 3.1416}, {0.0, 3.1416, 4.7124}}) {
    std::array<Corner, 3> open, close;
    for (size_t i = 0; i < 3; ++i) {
      open[i] = corner(turns[i], 0);
      close[i] = corner(turns[i], motion);
    }
    builder.AddTriangle(open, close);
  }
  return builder.Build();
}

TEST(Effort, WhatStandsStillHasOneInstantAndAsManyLinesAsItsEdgesNeed) {
  const auto frame = Square(0);
  const double samples[] = {Render(*frame, Target(0.2)).samples, Render(*frame, Target(0.002)).samples,
                            Render(*frame, Target(1e-4)).samples};
  EXPECT_EQ(samples[0], 2);
  EXPECT_GT(samples[1], samples[0]);
  EXPECT_EQ(samples[2], 16);
}

/// Triangles of some pixels that fly through the tile in all directions, in front of one another.
std::shared_ptr<const FrameScene> Debris(uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(-1, 1);
  FrameSceneBuilder builder(OrthographicView(32, 32));
  for (int i = 0; i < 150; ++i) {
    std::array<Corner, 3> open, close;
    const double x = 16 + 40 * unit(random), y = 16 + 40 * unit(random), depth = 0.5 + 0.4 * unit(random);
    const double dx = 30 * unit(random), dy = 30 * unit(random);
    for (size_t k = 0; k < 3; ++k) {
      const double px = x + 8 * unit(random), py = y + 8 * unit(random);
      open[k] = {px - dx, py - dy, depth};
      close[k] = {px + dx, py + dy, depth};
    }
    builder.AddTriangle(open, close);
  }
  return builder.Build();
}

TEST(Effort, WhatMovesIsNotTakenForWhatLinesMiss) {
  // What one line misses of it is another thing at each instant: instants help, and cost less than lines.
  double lines = 0;
  constexpr int kSeeds = 16;
  for (uint64_t seed = 1; seed <= kSeeds; ++seed) {
    lines += double(Render(*Debris(seed), Target(0.01)).lines) / (kSeeds * 64);
  }
  EXPECT_LT(lines, 1.5) << "times those of 1h1v, seeds 1 to " << kSeeds;
}

TEST(Effort, WhatIsSaidIsDone) {
  const auto frame = Square(12);
  for (const int instants : {1, 3, 17}) {
    EXPECT_EQ(Render(*frame, Pinned(PatternKind::k2h2v, instants)).samples, 4 * instants);
  }
  // A pattern that is named is kept.
  RenderSettings named = Target(0.003);
  named.pattern = PatternKind::kRgls;
  EXPECT_EQ(std::fmod(Render(*frame, named).samples, 4), 0);
  named.pattern = PatternKind::k4h4v;
  EXPECT_EQ(Render(*Square(0), named).samples, 8);

  // Without an error, or without colours to measure it by, motion decides: 12 pixels, one instant in two.
  RenderSettings by_motion;
  by_motion.target_error.reset();
  EXPECT_EQ(Render(*frame, by_motion).samples, 4 * 8);
  EXPECT_EQ(Render(*frame, Target(0.003), false).samples, 4 * 8);
}

TEST(Effort, NoMoreThanAnInstantEveryHalfPixelOfMotion) {
  // 16 instants at least where anything moves by so much, at a step of 1; half a pixel asks for twice as
  // many.
  EXPECT_EQ(Render(*Square(3), Target(1e-5)).samples, 16 * 32);
}

}  // namespace
}  // namespace shutterline::engine::effort_test
