#include "common/base/work_limit.h"

#include <absl/status/statusor.h>
#include <gtest/gtest.h>

#include <stdexcept>
#include <thread>

#include "tests/support/fake_clock.h"

namespace shutterline {
namespace {

TEST(WorkLimit, EndsWorkThatTakesLongerAndSaysSo) {
  test::FakeClock clock;
  int steps = 0;
  const auto work = [&]() -> absl::StatusOr<int> {
    for (; steps < 100; ++steps) {
      CheckWork();
      clock.Advance(absl::Seconds(1));
    }
    return steps;
  };
  const absl::StatusOr<int> stopped = WithinWorkLimit(clock, absl::Seconds(10), "count", work);
  EXPECT_EQ(stopped.status(),
            absl::DeadlineExceededError("count: it took longer than the 10s that are allowed"));
  EXPECT_EQ(steps, 11) << "ten seconds are allowed";
  EXPECT_EQ(WithinWorkLimit(clock, absl::InfiniteDuration(), "count", work).value(), 100);
  CheckWork();  // Nobody's time is limited any more.
}

TEST(WorkLimit, WhatOthersTakeIsNotCounted) {
  test::FakeClock clock;
  const auto work = [&] {
    {
      const WorkPause pause;
      clock.Advance(absl::Hours(1));
    }
    CheckWork();
    clock.Advance(absl::Seconds(11));
    CheckWork();
    return absl::OkStatus();
  };
  EXPECT_TRUE(absl::IsDeadlineExceeded(WithinWorkLimit(clock, absl::Seconds(10), "wait", work)));
  EXPECT_TRUE(WithinWorkLimit(clock, absl::Seconds(12), "wait", work).ok());
}

TEST(WorkLimit, IsOfAThreadAndOfThoseThatAreToldOfIt) {
  test::FakeClock clock;
  const WorkLimit outer(clock, absl::Hours(1)), inner(clock, absl::Seconds(1));
  const WorkLimitScope scope(&outer);
  {
    const WorkLimitScope nested(&inner);
    clock.Advance(absl::Seconds(2));
    EXPECT_THROW(CheckWork(), WorkLimit::Exceeded);
    const WorkLimit* const limit = WorkLimit::Current();
    std::thread([&] {
      CheckWork();
      EXPECT_THROW(CheckWork(limit), WorkLimit::Exceeded);
      const WorkLimitScope told(limit);
      EXPECT_THROW(CheckWork(), WorkLimit::Exceeded);
    }).join();
  }
  CheckWork();
  EXPECT_EQ(WorkLimit::Current(), &outer);
}

TEST(WorkLimit, LeavesOtherExceptionsAlone) {
  test::FakeClock clock;
  const auto work = []() -> absl::Status { throw std::runtime_error("a bug"); };
  EXPECT_THROW((void)WithinWorkLimit(clock, absl::Seconds(1), "fail", work), std::runtime_error);
  EXPECT_EQ(WorkLimit::Current(), nullptr);
}

}  // namespace
}  // namespace shutterline
