// The vector resolver beside the plain one: two ways to the same weights.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <random>
#include <utility>
#include <vector>

#include "tests/support/frame_scene_builder.h"
#include "tests/support/random_soup.h"
#include "tests/support/resolved_tile.h"
#include "tests/support/scalar_resolver.h"
#include "worker/engine/slice/resolver_slice.h"

namespace shutterline::engine::resolver_test {
namespace {

using Weights = std::map<std::pair<int64_t, uint32_t>, double>;

Weights WeightsBy(const Resolver& resolver, const FrameScene& frame, const std::vector<uint32_t>& candidates,
                  ColorFilm* flat = nullptr) {
  std::vector<PrimitiveTraits> traits;
  for (const FramePrimitive& primitive : frame.primitives) {
    traits.push_back({.cull_back = !primitive.material->double_sided});
  }
  PairWeights pairs;
  RenderStats stats;
  resolver.Resolve({frame, traits, {0, 0, 32, 32}, candidates}, pairs, flat, stats);
  Weights weights;
  for (int64_t pixel = 0; pixel < 32 * 32; ++pixel) {
    uint64_t covered = 0;
    pairs.ForEach(pixel, [&](const PixelPair& pair) {
      covered += pair.weight;
      weights[{pixel, pair.triangle}] += double(pair.weight) / double(pairs.total());
    });
    EXPECT_LE(covered, pairs.total());
  }
  return weights;
}

std::vector<uint32_t> AllOf(const FrameScene& frame) {
  std::vector<uint32_t> all(frame.triangles.size());
  std::iota(all.begin(), all.end(), 0u);
  return all;
}

TEST(ResolverSlice, AgreesWithThePlainWay) {
  // Depths are single precision in one and double in the other, so places where surfaces cross move by that
  // much; all else is rounding of the last subpixel.
  for (const PatternKind pattern : {PatternKind::k1h1v, PatternKind::kRgls}) {
    for (uint64_t seed = 1; seed <= 40; ++seed) {
      SCOPED_TRACE("seed " + std::to_string(seed));
      const auto frame = RandomSoup(seed, int(seed * 6), seed % 3 == 0);
      const RenderSettings settings = LineSettings(pattern, 8);
      const Weights fast = WeightsBy(ResolverSlice(settings), *frame, AllOf(*frame));
      const Weights plain = WeightsBy(ScalarResolver(settings), *frame, AllOf(*frame));
      double sum = 0;
      double worst = 0;
      const auto compare = [&](const Weights& a, const Weights& b) {
        for (const auto& [key, weight] : a) {
          const auto found = b.find(key);
          const double difference = std::abs(weight - (found == b.end() ? 0 : found->second));
          sum += difference;
          worst = std::max(worst, difference);
        }
      };
      compare(fast, plain);
      compare(plain, fast);
      EXPECT_LT(worst, 2e-3);
      EXPECT_LT(sum / (32 * 32), 1e-5);
    }
  }
}

TEST(ResolverSlice, OrderOfTrianglesDoesNotMatter) {
  for (uint64_t seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const auto frame = RandomSoup(seed, 200, true);
    const ResolverSlice resolver(LineSettings(PatternKind::kRgls, 16));
    std::vector<uint32_t> candidates = AllOf(*frame);
    const Weights ordered = WeightsBy(resolver, *frame, candidates);
    std::mt19937_64 random(seed);
    std::shuffle(candidates.begin(), candidates.end(), random);
    EXPECT_EQ(WeightsBy(resolver, *frame, candidates), ordered);
  }
}

TEST(ResolverSlice, NumbersOfTrianglesDoNotMatter) {
  // Only where depths are equal do numbers decide, which they are not here.
  for (uint64_t seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const auto frame = RandomSoup(seed, 300, true);
    const ResolverSlice resolver(LineSettings(PatternKind::kRgls, 16));
    const std::vector<uint32_t> candidates = AllOf(*frame);
    const Weights ordered = WeightsBy(resolver, *frame, candidates);
    FrameScene renumbered = *frame;
    std::vector<uint32_t> source = candidates;
    std::mt19937_64 random(seed);
    std::shuffle(source.begin(), source.end(), random);
    for (size_t i = 0; i < source.size(); ++i) renumbered.triangles[i] = frame->triangles[source[i]];
    Weights back;
    for (const auto& [key, weight] : WeightsBy(resolver, renumbered, candidates)) {
      back[{key.first, source[key.second]}] = weight;
    }
    EXPECT_EQ(back, ordered);
  }
}

TEST(ResolverSlice, FilmAndPairsHoldTheSameCoverage) {
  for (uint64_t seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const auto frame = RandomSoup(seed, 120);
    const ResolverSlice resolver(LineSettings(PatternKind::kRgls, 8));
    // One colour for each triangle: the film's sums are then sums of weights.
    ColorFilm flat([](uint32_t triangle) {
      const V3f color(triangle % 2 == 0 ? 1 : 0, 1, 0);
      ColorNodes nodes;
      nodes.corners = {color, color, color};
      return nodes;
    });
    WeightsBy(resolver, *frame, AllOf(*frame), &flat);
    const Weights pairs = WeightsBy(resolver, *frame, AllOf(*frame));
    std::vector<std::array<double, 2>> expected(32 * 32, {0, 0});
    for (const auto& [key, weight] : pairs) {
      expected[size_t(key.first)][0] += key.second % 2 == 0 ? weight : 0;
      expected[size_t(key.first)][1] += weight;
    }
    const double total = double(uint64_t{8} * (uint64_t{1} << 24) * 4);
    for (int64_t pixel = 0; pixel < 32 * 32; ++pixel) {
      EXPECT_NEAR(flat.At(pixel)[0] / total, expected[size_t(pixel)][0], 1e-12);
      EXPECT_NEAR(flat.At(pixel)[3] / total, expected[size_t(pixel)][1], 1e-12);
      EXPECT_EQ(flat.At(pixel)[1], flat.At(pixel)[3]);
    }
  }
}

}  // namespace
}  // namespace shutterline::engine::resolver_test
