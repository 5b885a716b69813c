// What people complain of in farms, each complaint a test that it does not hold here. Seams and missing
// tiles: tests/server/quarantine_test.cpp; frames rendered twice: tests/server/lease_adoption_test.cpp as
// well.
#include <absl/strings/str_cat.h>
#include <gtest/gtest.h>

#include "server/schedule/tile_scheduler.h"
#include "tests/support/fake_clock.h"

namespace shutterline::server {
namespace {

class ComplaintTest : public testing::Test {
 protected:
  test::FakeClock clock_;
  TileScheduler scheduler_{clock_, SchedulerOptions{}};
};

TEST_F(ComplaintTest, TheSameFrameRunsTwiceAfterAFlappingHost) {
  scheduler_.AddJob(1, 1, 2, 1);
  scheduler_.AddWorker(1, "flapping", 1, "boot");
  const Lease before = *scheduler_.Grant(1);
  scheduler_.LoseWorker(1);
  // Back within the grace, as a new registration: the old one is given up, the tile is its own again.
  clock_.Advance(absl::Milliseconds(900));
  scheduler_.RemoveWorker(1);
  scheduler_.AddWorker(2, "flapping", 1, "boot");
  EXPECT_EQ(scheduler_.Adopt(2, 1, 0, before.tiles)->tiles, before.tiles);
  scheduler_.AddWorker(3, "other", 1);
  EXPECT_NE(scheduler_.Grant(3)->tiles, before.tiles);
  EXPECT_FALSE(scheduler_.Grant(3).has_value());
}

TEST_F(ComplaintTest, AFrameIsRunningForEverAfterALostCompletionReport) {
  scheduler_.AddJob(1, 1, 1, 1);
  scheduler_.AddWorker(1, "believes that it has reported", 1);
  scheduler_.AddWorker(2, "other", 1);
  ASSERT_TRUE(scheduler_.Grant(1).has_value());
  for (int second = 0; second < 15; ++second) {
    clock_.Advance(absl::Seconds(1));
    scheduler_.Renew(1, {});  // Alive, but it names the lease no more.
    scheduler_.Renew(2, {});
    scheduler_.Expire();
  }
  EXPECT_TRUE(scheduler_.Grant(2).has_value());
}

TEST_F(ComplaintTest, BusyWorkersAreDeclaredDead) {
  scheduler_.AddJob(1, 1, 1, 1);
  scheduler_.AddWorker(1, "busy", 1);
  const Lease lease = *scheduler_.Grant(1);
  for (int beat = 0; beat < 3600 / 5; ++beat) {
    clock_.Advance(absl::Seconds(5));
    scheduler_.Renew(1, {lease.id});
    const TileScheduler::Expired expired = scheduler_.Expire();
    ASSERT_TRUE(expired.leases.empty() && expired.workers.empty()) << "after " << beat * 5 << " s";
  }
  EXPECT_TRUE(scheduler_.Complete(1, 0, 0, 1, absl::Hours(1)));
}

TEST_F(ComplaintTest, ShortTasksDrownInOverhead) {
  scheduler_.AddJob(1, 1, 128, 64);
  scheduler_.AddWorker(1, "fast", 1);
  scheduler_.Complete(1, 0, scheduler_.Grant(1)->tiles[0], 1, absl::Milliseconds(1));
  EXPECT_EQ(scheduler_.Grant(1)->tiles.size(), 250u);  // A quarter of a second, whatever a tile takes.
}

TEST_F(ComplaintTest, ASilentCapLeavesWorkersIdle) {
  constexpr int kWorkers = 1000, kSlots = 4, kLeases = 3 * kSlots;
  scheduler_.AddJob(1, 2, 128, 128);
  for (WorkerId id = 1; id <= kWorkers; ++id) scheduler_.AddWorker(id, absl::StrCat(id), kSlots);
  for (int round = 0; round < kLeases; ++round) {
    for (WorkerId id = 1; id <= kWorkers; ++id) ASSERT_TRUE(scheduler_.Grant(id).has_value()) << id;
  }
}

TEST_F(ComplaintTest, ABigJobStarvesTheSmallOneBehindIt) {
  scheduler_.AddJob(1, 100, 64, 64, 0, "big");
  scheduler_.AddWorker(1, "only", 1);
  for (int i = 0; i < 50; ++i) {
    const Lease lease = *scheduler_.Grant(1);
    clock_.Advance(absl::Milliseconds(100) * int64_t(lease.tiles.size()));
    scheduler_.Renew(1, {lease.id});
    for (const uint32_t tile : lease.tiles) {
      scheduler_.Complete(1, lease.frame, tile, 1, absl::Milliseconds(100));
    }
  }
  scheduler_.AddJob(2, 1, 2, 2, 0, "small");
  int leases = 0;
  while (scheduler_.Grant(1)->job != 2) ASSERT_LT(++leases, 10);
}

}  // namespace
}  // namespace shutterline::server
