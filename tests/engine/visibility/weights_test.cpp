#include <gtest/gtest.h>

#include <map>
#include <random>
#include <utility>

#include "common/math/tolerance.h"
#include "tests/support/line_weights.h"
#include "worker/engine/visibility/pair_weights.h"
#include "worker/engine/visibility/time_samples.h"

namespace shutterline::engine {
namespace {

TEST(LineWeights, DifferenceBuffersAddUpToThePieces) {
  for (uint64_t seed = 1; seed <= 32; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937_64 random(seed);
    LineWeights line;
    line.Reset(10);
    // Twice, as one object serves many lines.
    for (int round = 0; round < 2; ++round) {
      std::map<std::pair<uint32_t, int>, uint64_t> expected;
      for (int i = 0; i < 200; ++i) {
        const auto index = uint32_t(random() % 10);
        const auto a = int32_t(random() % (uint64_t{kMaxLinePixels} << kSubpixelBits));
        const auto b = int32_t(random() % (uint64_t{kMaxLinePixels} << kSubpixelBits));
        // Ends on pixel borders are as likely as within.
        const int32_t begin =
            i % 2 == 0 ? std::min(a, b) : (std::min(a, b) >> kSubpixelBits) << kSubpixelBits;
        const int32_t end = std::max(a, b) + 1;
        const uint64_t weight = 1 + random() % (uint64_t{1} << 20);
        line.Add(index, begin, end, weight);
        for (int32_t from = begin; from < end;) {
          const int step = from >> kSubpixelBits;
          const auto to = int32_t(std::min<int64_t>(end, int64_t(step + 1) << kSubpixelBits));
          expected[{index, step}] += uint64_t(to - from) * weight;
          from = to;
        }
      }
      std::map<std::pair<uint32_t, int>, uint64_t> got;
      line.ForEachAndClear([&](uint32_t index, int step, uint64_t weight) { got[{index, step}] += weight; });
      EXPECT_EQ(got, expected);
    }
  }
}

TEST(PairWeights, KeepsTrianglesAndBinsApart) {
  PairWeights weights;
  weights.Reset(4, 100);
  weights.Add(2, {.triangle = 7, .weight = 10, .b1 = 0.5});
  weights.Add(2, {.triangle = 7, .weight = 30, .b1 = 0.1});
  weights.Add(2, {.triangle = 7, .bin = 1, .bins_log2 = 1, .weight = 5});
  weights.Add(2, {.triangle = 9, .weight = 1});
  int pairs = 0;
  weights.ForEach(2, [&](const PixelPair& pair) {
    ++pairs;
    if (pair.triangle != 7 || pair.bin != 0) return;
    EXPECT_EQ(pair.weight, 40u);
    EXPECT_DOUBLE_EQ(pair.b1 / double(pair.weight), (10 * 0.5 + 30 * 0.1) / 40);
  });
  EXPECT_EQ(pairs, 3);
  weights.ForEach(1, [&](const PixelPair&) { ADD_FAILURE() << "another pixel's pair"; });
}

TEST(PairWeights, AMillionPairsInAPixel) {
  // A search through the list of each would take hours.
  PairWeights weights;
  weights.Reset(1, 1);
  constexpr uint32_t kPairs = 1000000;
  for (int round = 0; round < 2; ++round) {
    for (uint32_t i = 0; i < kPairs; ++i) weights.Add(0, {.triangle = i * 7, .weight = i});
  }
  uint64_t pairs = 0;
  uint64_t sum = 0;
  weights.ForEach(0, [&](const PixelPair& pair) {
    ++pairs;
    sum += pair.weight;
    ASSERT_EQ(pair.weight, 2 * uint64_t{pair.triangle / 7});
  });
  EXPECT_EQ(pairs, kPairs);
  EXPECT_EQ(sum, uint64_t{kPairs} * (kPairs - 1));
}

TEST(TimeSamples, FollowMotionInPowersOfTwoThatDivideTheTotal) {
  RenderSettings settings;
  const TimeSamples samples(settings);
  int64_t last = 0;
  for (double motion = 1e-6; motion < kMostMotionPixels; motion *= 1.3) {
    const int64_t n = samples.InstantsFor(motion);
    EXPECT_EQ(n & (n - 1), 0) << motion;
    EXPECT_GE(n, last) << "fewer instants for more motion";
    EXPECT_GE(double(n) * settings.time_step, motion) << "more than a time step of motion between instants";
    EXPECT_EQ(samples.WeightOf(n) * n, samples.WeightPerLine());
    last = n;
  }
  EXPECT_EQ(samples.InstantsFor(1e-6), 1);
  EXPECT_EQ(samples.InstantsFor(60), 32);
  EXPECT_EQ(samples.InstantsFor(0), 1);
  // The largest motion at the smallest step that settings allow still fits.
  settings.time_step = 1e-3;
  ASSERT_TRUE(Validate(settings).ok());
  EXPECT_GE(double(TimeSamples(settings).InstantsFor(kMostMotionPixels)), kMostMotionPixels / 1e-3);
}

TEST(TimeSamples, PinnedNumberIsTakenWhateverTheMotion) {
  RenderSettings settings;
  settings.time_samples = 7;
  const TimeSamples samples(settings);
  EXPECT_EQ(samples.InstantsFor(0.001), 7);
  EXPECT_EQ(samples.InstantsFor(kMostMotionPixels), 7);
  EXPECT_EQ(samples.WeightOf(7) * 7, samples.WeightPerLine());
}

}  // namespace
}  // namespace shutterline::engine
