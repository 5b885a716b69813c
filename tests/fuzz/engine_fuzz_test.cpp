// A short run of engine-fuzz, over seeds of its own.
#include <gtest/gtest.h>

#include <chrono>

#include "tests/fuzz/fuzz_engine.h"

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

}  // namespace
}  // namespace shutterline::engine
