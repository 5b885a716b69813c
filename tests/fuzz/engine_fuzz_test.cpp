// A short run of engine-fuzz, over seeds of its own.
#include <gtest/gtest.h>

#include <chrono>

#include "tests/fuzz/fuzz_engine.h"
#include "tests/fuzz/kernel_checks.h"

namespace shutterline::engine {
namespace {

TEST(EngineFuzz, NothingBreaksInAShortRun) {
  using Clock = std::chrono::steady_clock;
  const auto stop = Clock::now() + std::chrono::seconds(2);
  uint64_t seed = 1;
  for (; seed <= 20 || (Clock::now() < stop && seed <= 400); ++seed) {
    ASSERT_EQ(FuzzEngine(seed), "") << "engine-fuzz --seed " << seed << " --count 1";
  }
}

// What broke once stays mended.

TEST(EngineFuzz, TiesInDepthShowTheSameOnEveryInstructionSet) {
  for (const uint64_t seed : {131, 280, 343, 450, 672, 864}) EXPECT_EQ(BrokenMarch(seed), "") << seed;
}

TEST(EngineFuzz, DenormalHeightsHaveFiniteCrossings) {
  for (const uint64_t seed : {35, 54, 114, 120, 178, 200, 212})
    EXPECT_EQ(BrokenPlacedSegments(seed), "") << seed;
}

TEST(EngineFuzz, FarCornersLeaveNothingToChance) {
  for (const uint64_t seed : {94, 149, 279, 316}) EXPECT_EQ(FuzzEngine(seed), "") << seed;
}

}  // namespace
}  // namespace shutterline::engine
