#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/schedule/tile_scheduler.h"
#include "server/schedule/tile_times.h"
#include "tests/support/fake_clock.h"

namespace shutterline::server {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

TEST(TileTimesTest, NinetyFifthOfTheLatestTiles) {
  TileTimes times;
  for (int i = 1; i <= 3; ++i) times.Add(i);
  EXPECT_EQ(times.NinetyFifth(), std::nullopt);
  times.Add(4);
  EXPECT_EQ(times.NinetyFifth(), 4);
  for (int i = 100; i >= 1; --i) times.Add(i);
  EXPECT_NEAR(*times.NinetyFifth(), 95, 1);
  for (int i = 0; i < 256; ++i) times.Add(7);
  EXPECT_EQ(times.NinetyFifth(), 7);  // What is old is forgotten.
}

class SpeculationTest : public testing::Test {
 protected:
  SpeculationTest() {
    scheduler_.AddJob(1, 1, 3, 2);
    for (WorkerId id = 1; id <= 3; ++id) scheduler_.AddWorker(id, std::string(1, char('a' + id)), 1);
    stuck_ = *scheduler_.Grant(1);
    for (int i = 0; i < 5; ++i) {
      const Lease lease = *scheduler_.Grant(2);
      clock_.Advance(absl::Milliseconds(400));
      for (const uint32_t tile : lease.tiles) {
        EXPECT_TRUE(scheduler_.Complete(1, 0, tile, 2, absl::Milliseconds(400)));
      }
    }
    EXPECT_EQ(scheduler_.QueuedTiles(), 0);
    Hear();
  }
  void Hear() {
    for (WorkerId id = 1; id <= 3; ++id) scheduler_.Renew(id, {stuck_.id});
  }

  test::FakeClock clock_;
  TileScheduler scheduler_{clock_, SchedulerOptions{}};
  Lease stuck_;  ///< Of worker 1: granted two seconds ago, when its neighbours took 0.4 s each.
};

TEST_F(SpeculationTest, LateTileIsCopiedOnceAndTheFirstResultEndsBothLeases) {
  const std::vector<Lease> copies = scheduler_.Speculate({2, 3});
  ASSERT_EQ(copies.size(), 1u);  // Two leases hold it now: enough.
  EXPECT_EQ(copies[0].worker, 2u);
  EXPECT_EQ(copies[0].tiles, stuck_.tiles);
  EXPECT_THAT(scheduler_.Speculate({3}), IsEmpty());
  EXPECT_EQ(scheduler_.Find(1)->remaining(), 1);
  EXPECT_TRUE(scheduler_.Complete(1, 0, stuck_.tiles[0], 2, absl::Milliseconds(400)));
  const std::vector<EndedLease> revoked = scheduler_.TakeRevoked();
  ASSERT_EQ(revoked.size(), 1u);
  EXPECT_EQ(revoked[0].id, stuck_.id);
  EXPECT_EQ(revoked[0].worker, 1u);
  EXPECT_EQ(scheduler_.LeasedTiles(1) + scheduler_.LeasedTiles(2), 0);
  EXPECT_FALSE(scheduler_.Complete(1, 0, stuck_.tiles[0], 1, absl::Seconds(3)));
}

TEST(DroppedTilesTest, ALeaseHearsOfEachTileThatAnotherHasDelivered) {
  test::FakeClock clock;
  TileScheduler scheduler(clock, SchedulerOptions{});
  scheduler.AddJob(1, 1, 40, 1);
  scheduler.AddWorker(1, "slow", 1);
  scheduler.AddWorker(2, "fast", 1);
  for (const WorkerId id : {1, 2}) {
    const Lease measured = *scheduler.Grant(id);
    ASSERT_TRUE(scheduler.Complete(1, 0, measured.tiles[0], id, absl::Milliseconds(1)));
  }
  const Lease lease = *scheduler.Grant(1);
  ASSERT_GT(lease.tiles.size(), 3u);
  EXPECT_TRUE(scheduler.Complete(1, 0, lease.tiles[0], 1, absl::Milliseconds(1)));
  EXPECT_THAT(scheduler.TakeDropped(), IsEmpty());  // Its own.
  EXPECT_TRUE(scheduler.Complete(1, 0, lease.tiles[2], 2, absl::Milliseconds(1)));
  EXPECT_FALSE(scheduler.Complete(1, 0, lease.tiles[2], 1, absl::Milliseconds(1)));
  const std::vector<DroppedTile> dropped = scheduler.TakeDropped();
  ASSERT_EQ(dropped.size(), 1u);
  EXPECT_EQ(dropped[0].lease, lease.id);
  EXPECT_EQ(dropped[0].worker, 1u);
  EXPECT_EQ(dropped[0].tile, lease.tiles[2]);
  EXPECT_THAT(scheduler.TakeRevoked(), IsEmpty());
  EXPECT_EQ(scheduler.LeasedTiles(1), int64_t(lease.tiles.size()) - 2);
  // The lease ends with its last tile: that is told at once, and nothing of its tiles.
  for (const uint32_t tile : lease.tiles) scheduler.Complete(1, 0, tile, 2, absl::Milliseconds(1));
  EXPECT_THAT(scheduler.TakeDropped(), IsEmpty());
  ASSERT_EQ(scheduler.TakeRevoked().size(), 1u);
}

TEST_F(SpeculationTest, TileStaysLeasedUntilBothCopiesAreGivenUp) {
  ASSERT_EQ(scheduler_.Speculate({3}).size(), 1u);
  scheduler_.RemoveWorker(1);
  EXPECT_EQ(scheduler_.QueuedTiles(), 0);
  scheduler_.RemoveWorker(3);
  EXPECT_EQ(scheduler_.QueuedTiles(), 1);
}

TEST_F(SpeculationTest, FailureOfOneCopyLeavesTheTileToTheOther) {
  ASSERT_EQ(scheduler_.Speculate({3}).size(), 1u);
  EXPECT_FALSE(scheduler_.Fail(1, 0, stuck_.tiles[0], 3, "no").has_value());
  EXPECT_EQ(scheduler_.QueuedTiles(), 0);
  EXPECT_THAT(scheduler_.Speculate({3}), IsEmpty());  // Not to the one that has failed it.
  EXPECT_TRUE(scheduler_.Complete(1, 0, stuck_.tiles[0], 1, absl::Seconds(3)));
}

TEST_F(SpeculationTest, NobodyCopiesHisOwnTilesOrThoseThatMayHaveKilledSomebody) {
  EXPECT_THAT(scheduler_.Speculate({1}), IsEmpty());
  scheduler_.BuryWorker(1);
  ASSERT_TRUE(scheduler_.Grant(2).has_value());
  clock_.Advance(absl::Seconds(10));
  Hear();
  EXPECT_THAT(scheduler_.Speculate({3}), IsEmpty());
}

TEST_F(SpeculationTest, PausedJobIsLeftAlone) {
  scheduler_.SetBlocked(1, TileScheduler::Block::kPaused, true);
  EXPECT_THAT(scheduler_.Speculate({2, 3}), IsEmpty());
}

TEST(SpeculationPatienceTest, WaitsForTwiceTheUsualTimeAndHalfASecond) {
  test::FakeClock clock;
  TileScheduler scheduler(clock, SchedulerOptions{});
  scheduler.AddJob(1, 1, 6, 1);
  scheduler.AddWorker(1, "a", 1);
  scheduler.AddWorker(2, "b", 1);
  const Lease stuck = *scheduler.Grant(1);
  for (int i = 0; i < 5; ++i) {
    const Lease lease = *scheduler.Grant(2);
    scheduler.Complete(1, 0, lease.tiles[0], 2, absl::Seconds(i == 4 ? 1 : 1.0 / 1024));
  }
  clock.Advance(absl::Seconds(2));
  EXPECT_THAT(scheduler.Speculate({2}), IsEmpty());
  clock.Advance(absl::Milliseconds(1));
  EXPECT_THAT(scheduler.Speculate({2}, absl::Milliseconds(400)), IsEmpty()) << "it may wait for company";
  clock.Advance(absl::Milliseconds(400));
  const std::vector<Lease> copies = scheduler.Speculate({2}, absl::Milliseconds(400));
  ASSERT_EQ(copies.size(), 1u);
  EXPECT_TRUE(copies[0].send_at_once);
}

}  // namespace
}  // namespace shutterline::server
