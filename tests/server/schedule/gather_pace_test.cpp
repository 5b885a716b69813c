#include "server/schedule/gather_pace.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace shutterline::server {
namespace {

/// Lets `rate` results a second come for a while, in ticks of 50 ms.
absl::Duration GatherAt(GatherPace& pace, absl::Duration& now, double rate, int64_t workers,
                        int seconds = 20) {
  double results = 0;
  for (int tick = 0; tick < 20 * seconds; ++tick) {
    now += absl::Milliseconds(50);
    const auto before = int64_t(results);
    results += rate / 20;
    pace.Count(int64_t(results) - before);
    pace.Tick(now, workers);
  }
  return pace.gather();
}

class GatherPaceTest : public testing::Test {
 protected:
  GatherPaceOptions options_;
  GatherPace pace_{options_};
  absl::Duration now_ = absl::Seconds(77);
};

TEST_F(GatherPaceTest, WhereLittleComesNothingIsHeldBack) {
  EXPECT_EQ(pace_.gather(), options_.least);
  EXPECT_EQ(GatherAt(pace_, now_, 20, 4), options_.least);
  EXPECT_EQ(GatherAt(pace_, now_, 1900, 4000), options_.least) << "however many are connected";
  EXPECT_EQ(GatherAt(pace_, now_, 30'000, 4), options_.least) << "four workers' messages are few";
}

TEST_F(GatherPaceTest, ThousandBusyWorkersSendAsManyMessagesAsAreWanted) {
  const double rate = 10'000, workers = 1000;
  const double gather = absl::ToDoubleSeconds(GatherAt(pace_, now_, rate, int64_t(workers)));
  EXPECT_NEAR(gather, 0.4, 0.01);
  const double in_a_message = 1 + gather * rate / workers;
  EXPECT_NEAR(rate / in_a_message, options_.messages_per_second, 0.02 * options_.messages_per_second);
}

TEST_F(GatherPaceTest, NobodyWaitsForLongerThanTheMost) {
  EXPECT_EQ(GatherAt(pace_, now_, 100'000, 4096), options_.most);
  EXPECT_EQ(GatherAt(pace_, now_, 1e12, int64_t{1} << 40), options_.most);
}

TEST_F(GatherPaceTest, FollowsTheLoadWithinSecondsAndRemembersWhatWasSaid) {
  const absl::Duration busy = GatherAt(pace_, now_, 10'000, 1000);
  EXPECT_GE(pace_.longest(), busy);
  now_ += absl::Seconds(1);  // Nothing comes any more.
  pace_.Tick(now_, 1000);
  EXPECT_LT(pace_.gather(), busy);
  EXPECT_EQ(GatherAt(pace_, now_, 0, 1000, 5), options_.least);
  EXPECT_GE(pace_.longest(), busy) << "who had nothing to send has not heard of it";
  GatherAt(pace_, now_, 0, 1000, 60);
  EXPECT_EQ(pace_.longest(), options_.least);
}

TEST_F(GatherPaceTest, LongGapsBetweenTicksAreNoLoad) {
  pace_.Tick(now_, 1000);
  pace_.Count(1'000'000);
  now_ += absl::Hours(1);
  pace_.Tick(now_, 1000);
  EXPECT_EQ(pace_.gather(), options_.least);
}

}  // namespace
}  // namespace shutterline::server
