#include "worker/session/backoff.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

namespace shutterline::worker {
namespace {

class FakeClock final : public Clock {
 public:
  absl::Duration Monotonic() const override { return now; }
  absl::Time Wall() const override { return absl::UnixEpoch() + now; }
  absl::Duration now = absl::Seconds(1000);
};

const BackoffOptions kOptions{.initial = absl::Milliseconds(100),
                              .max = absl::Seconds(2),
                              .multiplier = 2,
                              .healthy_after = absl::Seconds(5)};

TEST(Backoff, GrowsToItsMaximumWithinJitter) {
  FakeClock clock;
  for (uint64_t seed = 0; seed < 100; ++seed) {
    SCOPED_TRACE(seed);
    Backoff backoff(clock, kOptions, seed);
    absl::Duration ceiling = kOptions.initial;
    for (int i = 0; i < 12; ++i) {
      const absl::Duration delay = backoff.NextDelay();
      EXPECT_GE(delay, ceiling / 2);
      EXPECT_LE(delay, ceiling);
      ceiling = std::min(ceiling * 2, kOptions.max);
    }
  }
}

TEST(Backoff, WorkersDoNotComeBackInStep) {
  FakeClock clock;
  std::set<absl::Duration> delays;
  for (uint64_t seed = 0; seed < 50; ++seed) delays.insert(Backoff(clock, kOptions, seed).NextDelay());
  EXPECT_EQ(delays.size(), 50u);
}

TEST(Backoff, OnlyAConnectionThatLastedStartsOver) {
  FakeClock clock;
  Backoff backoff(clock, kOptions, 1);
  for (int i = 0; i < 10; ++i) backoff.NextDelay();

  // Accepted and dropped at once: no tight loop.
  backoff.Connected();
  clock.now += kOptions.healthy_after - absl::Milliseconds(1);
  EXPECT_GE(backoff.NextDelay(), kOptions.max / 2);

  backoff.Connected();
  clock.now += kOptions.healthy_after;
  EXPECT_LE(backoff.NextDelay(), kOptions.initial);

  // The good connection counts once: time without one is not health.
  clock.now += absl::Hours(1);
  const absl::Duration second = backoff.NextDelay();
  EXPECT_GE(second, kOptions.initial);
  EXPECT_LE(second, kOptions.initial * 2);
}

}  // namespace
}  // namespace shutterline::worker
