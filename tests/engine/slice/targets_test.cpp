// The kernels give the same bits on every instruction set.
#include <gtest/gtest.h>

#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "tests/support/only_target.h"
#include "tests/support/random_soup.h"
#include "tests/support/resolved_tile.h"
#include "worker/engine/slice/kernels.h"
#include "worker/engine/slice/resolver_slice.h"

namespace shutterline::engine::targets_test {
namespace {

/// Everything that a resolver says of a tile.
struct Result {
  std::map<std::tuple<int64_t, uint32_t, uint16_t>, std::tuple<uint64_t, double, double>> pairs;
  std::vector<std::array<double, 4>> flat;
  std::vector<uint64_t> spreads;
  friend bool operator==(const Result&, const Result&) = default;
};

/// With a filter the pixels' sums and pairs are those that it spreads.
Result ResolveSoup(uint64_t seed, bool curved, const PixelFilter* filter) {
  const auto frame = RandomSoup(seed, 150, curved);
  std::vector<PrimitiveTraits> traits;
  for (const FramePrimitive& primitive : frame->primitives) {
    traits.push_back({.cull_back = !primitive.material->double_sided, .needs_position = true});
  }
  std::vector<uint32_t> candidates(frame->triangles.size());
  std::iota(candidates.begin(), candidates.end(), 0u);
  PairWeights weights;
  ColorFilm film([](uint32_t triangle) -> std::optional<ColorNodes> {
    // Constant, linear, quadratic or apart.
    if (triangle % 4 == 3) return std::nullopt;
    const V3f color(1.0f / float(triangle + 1), 0.5f, 0.25f);
    ColorNodes nodes;
    nodes.corners = {color, color, color};
    nodes.middles = {color, color, V3f(1, 0, 1)};
    nodes.quadratic = triangle % 4 == 2;
    if (triangle % 4 == 1) nodes.corners[2] = V3f(0, 1, 0);
    return nodes;
  });
  RenderStats stats;
  ResolverSlice(LineSettings(PatternKind::kRgls, 16))
      .Resolve({*frame, traits, {0, 0, 32, 32}, candidates, nullptr, filter}, weights, &film, stats);
  Result result;
  for (int64_t pixel = 0; pixel < 32 * 32; ++pixel) {
    weights.ForEach(pixel, [&](const PixelPair& pair) {
      result.pairs[{pixel, pair.triangle, pair.bin}] = {pair.weight, pair.b1, pair.b2};
      for (const uint64_t weight : weights.SpreadOf(weights.NumberOf(pair))) result.spreads.push_back(weight);
    });
    result.flat.push_back(film.At(pixel));
  }
  return result;
}

TEST(Targets, AllGiveTheSameBits) {
  for (uint64_t seed = 1; seed <= 12; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const std::optional<PixelFilter> filter =
        seed % 3 == 0 ? std::optional<PixelFilter>(std::in_place, FilterKind::kGaussian, 1.5) : std::nullopt;
    const PixelFilter* const wide = filter ? &*filter : nullptr;
    const Result best = ResolveSoup(seed, seed % 2 == 0, wide);
    ASSERT_FALSE(best.pairs.empty());
    std::set<std::string> seen{KernelTarget()};
    ForEachTarget([&] {
      seen.insert(KernelTarget());
      EXPECT_TRUE(ResolveSoup(seed, seed % 2 == 0, wide) == best) << KernelTarget();
    });
    // At least the machine's own and an older one have been compared.
    EXPECT_GE(seen.size(), 2u);
  }
}

}  // namespace
}  // namespace shutterline::engine::targets_test
