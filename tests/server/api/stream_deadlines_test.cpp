#include "server/api/stream_deadlines.h"

#include <absl/synchronization/notification.h>
#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "tests/support/fake_clock.h"

namespace shutterline::server {
namespace {

TEST(StreamDeadlines, ExpireOnceAndInTime) {
  test::FakeClock clock;
  StreamDeadlines deadlines(clock);
  int first = 0, second = 0;
  deadlines.Add(absl::Seconds(10), [&] { ++first; });
  deadlines.Add(absl::Seconds(20), [&] { ++second; });
  clock.Advance(absl::Seconds(9));
  deadlines.Tick();
  EXPECT_EQ(first, 0);
  clock.Advance(absl::Seconds(1));
  deadlines.Tick();
  deadlines.Tick();
  EXPECT_EQ(first, 1);
  EXPECT_EQ(second, 0);
  clock.Advance(absl::Hours(1));
  deadlines.Tick();
  EXPECT_EQ(first, 1);
  EXPECT_EQ(second, 1);
}

TEST(StreamDeadlines, DoNotExpireAfterCancelAndMayCancelThemselves) {
  test::FakeClock clock;
  StreamDeadlines deadlines(clock);
  int expired = 0;
  const StreamDeadlines::Id cancelled = deadlines.Add(absl::Seconds(1), [&] { ++expired; });
  StreamDeadlines::Id own = 0;
  own = deadlines.Add(absl::Seconds(1), [&] { deadlines.Cancel(own); });
  deadlines.Cancel(cancelled);
  deadlines.Cancel(cancelled);
  deadlines.Cancel(12345);
  clock.Advance(absl::Seconds(2));
  deadlines.Tick();
  EXPECT_EQ(expired, 0);
}

TEST(StreamDeadlines, CancelWaitsForWhatRuns) {
  test::FakeClock clock;
  StreamDeadlines deadlines(clock);
  absl::Notification started, go_on;
  std::atomic<bool> ended = false;
  const StreamDeadlines::Id id = deadlines.Add(absl::Seconds(1), [&] {
    started.Notify();
    go_on.WaitForNotification();
    ended = true;
  });
  clock.Advance(absl::Seconds(1));
  std::thread ticker([&] { deadlines.Tick(); });
  started.WaitForNotification();
  std::thread canceller([&] {
    deadlines.Cancel(id);
    EXPECT_TRUE(ended) << "Cancel came back while the deadline was at work";
  });
  go_on.Notify();
  canceller.join();
  ticker.join();
}

}  // namespace
}  // namespace shutterline::server
