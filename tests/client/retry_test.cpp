#include "client/retry.h"

#include <gtest/gtest.h>
#include <signal.h>

#include <thread>
#include <vector>

namespace shutterline::client::retry_test {
namespace {

class HandClock : public Clock {
 public:
  absl::Duration Monotonic() const override { return now; }
  absl::Time Wall() const override { return absl::UnixEpoch() + now; }
  absl::Duration now;
};

const absl::Status kAway = absl::UnavailableError("away");

TEST(Backoff, PausesGrowToTheirLimitAndPatienceEnds) {
  HandClock clock;
  std::vector<absl::Duration> pauses;
  RetryPolicy policy;
  Backoff backoff(policy, nullptr, clock, [&](absl::Duration pause) {
    pauses.push_back(pause);
    clock.now += pause;
  });
  while (backoff.PauseAfter(kAway)) ASSERT_LT(pauses.size(), 1000u);
  absl::Duration sum;
  for (size_t i = 0; i < pauses.size(); ++i) {
    const absl::Duration nominal =
        std::min(policy.first_pause * (int64_t{1} << std::min<size_t>(i, 20)), policy.longest_pause);
    EXPECT_LE(pauses[i], nominal * 1.2) << i;
    if (i + 1 < pauses.size()) {
      EXPECT_GE(pauses[i], nominal * 0.8) << i;
    }
    sum += pauses[i];
  }
  EXPECT_EQ(sum, policy.patience) << "the last pause ends with patience, not after it";
}

TEST(Backoff, ProgressRestoresPatience) {
  HandClock clock;
  RetryPolicy policy;
  Backoff backoff(policy, nullptr, clock, [&](absl::Duration pause) { clock.now += pause; });
  for (int i = 0; i < 100; ++i) {
    EXPECT_TRUE(backoff.PauseAfter(kAway)) << i;
    clock.now += policy.patience * 0.7;
    backoff.Progress();
    EXPECT_FALSE(backoff.failing());
  }
}

TEST(Backoff, OnlyUnavailableIsTriedAgain) {
  Backoff backoff(RetryPolicy(), nullptr);
  for (const absl::Status& status :
       {absl::InvalidArgumentError("x"), absl::DeadlineExceededError("x"), absl::InternalError("x"),
        absl::CancelledError("x"), absl::NotFoundError("x")}) {
    EXPECT_FALSE(backoff.PauseAfter(status)) << status;
  }
}

TEST(Interrupt, EndsAPauseAndRunsLiveActionsOnce) {
  Interrupt interrupt;
  int live = 0, gone = 0;
  {
    Interrupt::Guard guard(&interrupt, [&] { ++gone; });
  }
  Interrupt::Guard guard(&interrupt, [&] { ++live; });
  std::thread raiser([&] { interrupt.Raise(); });
  interrupt.WaitFor(absl::InfiniteDuration());
  raiser.join();
  interrupt.Raise();
  EXPECT_EQ(live, 1);
  EXPECT_EQ(gone, 0);
  Interrupt::Guard late(&interrupt, [&] { ++live; });
  EXPECT_EQ(live, 2) << "a guard that comes late is told at once";
  Backoff backoff(RetryPolicy(), &interrupt);
  EXPECT_FALSE(backoff.PauseAfter(kAway));
}

TEST(Interrupt, SignalsRaiseIt) {
  for (const int number : {SIGINT, SIGTERM}) {
    Interrupt interrupt;
    const SignalInterrupt signals(interrupt);
    ASSERT_EQ(raise(number), 0);
    interrupt.WaitFor(absl::InfiniteDuration());
    EXPECT_TRUE(interrupt.raised());
  }
}

}  // namespace
}  // namespace shutterline::client::retry_test
