#include "server/observe/desired_workers.h"

#include <gtest/gtest.h>

namespace shutterline::server {
namespace {

FarmTotals Work(int64_t tiles, double seconds, int64_t workers, int64_t slots) {
  FarmTotals totals;
  totals.remaining_tiles = tiles;
  totals.remaining_seconds = seconds;
  totals.workers = workers;
  totals.slots = slots;
  return totals;
}

constexpr absl::Duration kTarget = absl::Seconds(60);

TEST(DesiredWorkersTest, FollowsTheWorkNotTheDepthOfTheQueue) {
  EXPECT_EQ(DesiredWorkers(Work(0, 0, 3, 12), kTarget), 0);
  // A million tiles of a microsecond are one worker's work.
  EXPECT_EQ(DesiredWorkers(Work(1'000'000, 1, 1, 1), kTarget), 1);
  // An hour of a thread: 60 threads for a minute, 15 workers of four.
  EXPECT_EQ(DesiredWorkers(Work(10'000, 3600, 0, 0), kTarget), 60);
  EXPECT_EQ(DesiredWorkers(Work(10'000, 3600, 2, 8), kTarget), 15);
  EXPECT_EQ(DesiredWorkers(Work(10'000, 3601, 2, 8), kTarget), 16);
}

TEST(DesiredWorkersTest, NeverMoreThanHaveATileForEveryThread) {
  EXPECT_EQ(DesiredWorkers(Work(10, 36'000, 0, 0), kTarget), 10);
  EXPECT_EQ(DesiredWorkers(Work(10, 36'000, 1, 4), kTarget), 3);
}

TEST(DesiredWorkersTest, AJobThatIsNotMeasuredWantsOneWorker) {
  EXPECT_EQ(DesiredWorkers(Work(10'000, 0, 0, 0), kTarget), 1);
}

}  // namespace
}  // namespace shutterline::server
