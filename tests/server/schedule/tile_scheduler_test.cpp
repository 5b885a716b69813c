#include "server/schedule/tile_scheduler.h"

#include <absl/strings/str_cat.h>
#include <gtest/gtest.h>

#include <map>
#include <random>
#include <set>
#include <tuple>

#include "tests/support/fake_clock.h"

namespace shutterline::server {
namespace {

using test::FakeClock;

class TileSchedulerTest : public testing::Test {
 protected:
  /// Completes all tiles of a lease, each in `time`.
  void Finish(const Lease& lease, absl::Duration time) {
    for (const uint32_t tile : lease.tiles) {
      EXPECT_TRUE(scheduler_.Complete(lease.job, lease.frame, tile, lease.worker, time));
    }
  }

  FakeClock clock_;
  TileScheduler scheduler_{clock_, SchedulerOptions{}};
};

TEST_F(TileSchedulerTest, FirstLeaseMeasuresThenBatchesAimAtTheBatchTime) {
  scheduler_.AddJob(1, 1, 64, 64);
  scheduler_.AddWorker(1, "a", 1);
  const std::optional<Lease> first = scheduler_.Grant(1);
  ASSERT_TRUE(first.has_value());
  EXPECT_EQ(first->tiles.size(), 1u);
  Finish(*first, absl::Milliseconds(10));
  EXPECT_EQ(scheduler_.Grant(1)->tiles.size(), 25u);  // 250 ms / 10 ms.
}

TEST_F(TileSchedulerTest, BatchesShrinkWithWhatRemainsAndTheSlotsThatShareIt) {
  scheduler_.AddJob(1, 1, 10, 10);
  scheduler_.AddWorker(1, "a", 4);
  scheduler_.AddWorker(2, "b", 6);
  Finish(*scheduler_.Grant(1), absl::Microseconds(1));
  EXPECT_EQ(scheduler_.Grant(1)->tiles.size(), 4u);  // 99 remaining / (2 × 10 slots).
  scheduler_.LoseWorker(2);
  EXPECT_EQ(scheduler_.Grant(1)->tiles.size(), 12u);  // 99 / (2 × 4): the lost one's slots do not count.
}

TEST_F(TileSchedulerTest, LeaseExpiresAtItsTtlUnlessAHeartbeatNamesIt) {
  scheduler_.AddJob(1, 1, 2, 1);
  scheduler_.AddWorker(1, "a", 1);
  const Lease kept = *scheduler_.Grant(1);
  const Lease dropped = *scheduler_.Grant(1);
  clock_.Advance(absl::Seconds(14));
  scheduler_.Renew(1, {kept.id});
  EXPECT_TRUE(scheduler_.Expire().leases.empty());
  clock_.Advance(absl::Seconds(1));
  const TileScheduler::Expired expired = scheduler_.Expire();
  ASSERT_EQ(expired.leases.size(), 1u);
  EXPECT_EQ(expired.leases[0].id, dropped.id);
  EXPECT_EQ(scheduler_.QueuedTiles(), 1);
  const std::optional<Lease> again = scheduler_.Grant(1);
  ASSERT_TRUE(again.has_value());
  EXPECT_EQ(again->tiles, dropped.tiles);
}

TEST_F(TileSchedulerTest, NobodyRenewsTheLeaseOfAnother) {
  scheduler_.AddJob(1, 1, 1, 1);
  scheduler_.AddWorker(1, "a", 1);
  scheduler_.AddWorker(2, "b", 1);
  const Lease lease = *scheduler_.Grant(1);
  clock_.Advance(absl::Seconds(10));
  scheduler_.Renew(2, {lease.id});
  scheduler_.Return(2, {lease.id});
  EXPECT_EQ(scheduler_.QueuedTiles(), 0);
  clock_.Advance(absl::Seconds(5));
  EXPECT_EQ(scheduler_.Expire().leases.size(), 1u);
}

TEST_F(TileSchedulerTest, BrokenStreamFreesItsTilesAfterTheGraceOnly) {
  scheduler_.AddJob(1, 1, 1, 1);
  scheduler_.AddWorker(1, "a", 1);
  scheduler_.AddWorker(2, "b", 1);
  ASSERT_TRUE(scheduler_.Grant(1).has_value());
  scheduler_.LoseWorker(1);
  clock_.Advance(absl::Milliseconds(999));
  EXPECT_TRUE(scheduler_.Expire().workers.empty());
  EXPECT_FALSE(scheduler_.Grant(2).has_value());
  clock_.Advance(absl::Milliseconds(1));
  EXPECT_EQ(scheduler_.Expire().workers, std::vector<WorkerId>{1});
  EXPECT_TRUE(scheduler_.Grant(2).has_value());
}

TEST_F(TileSchedulerTest, WhatOthersHaveNotBroughtBackIsToBeSentAtOnce) {
  scheduler_.AddJob(1, 1, 8, 1);
  scheduler_.AddWorker(1, "a", 1);
  scheduler_.AddWorker(2, "b", 1);
  const Lease first = *scheduler_.Grant(1);
  EXPECT_FALSE(first.send_at_once);
  scheduler_.Return(1, {first.id});
  const Lease again = *scheduler_.Grant(2);
  EXPECT_EQ(again.tiles, first.tiles);
  EXPECT_TRUE(again.send_at_once);
  EXPECT_FALSE(scheduler_.Grant(2)->send_at_once);
  // Who died of a tile may have finished others of its lease, and not sent them: then the blame falls on the
  // first of those. It is the one that is found out next.
  scheduler_.LoseWorker(2);
  clock_.Advance(absl::Seconds(1));
  scheduler_.Expire();
  const Lease suspect = *scheduler_.Grant(1);
  EXPECT_EQ(suspect.tiles, first.tiles);
  EXPECT_TRUE(suspect.send_at_once);
}

TEST_F(TileSchedulerTest, WorkerThatIsBackInTimeKeepsItsLeases) {
  scheduler_.AddJob(1, 1, 1, 1);
  scheduler_.AddWorker(1, "a", 1);
  ASSERT_TRUE(scheduler_.Grant(1).has_value());
  scheduler_.LoseWorker(1);
  clock_.Advance(absl::Milliseconds(500));
  scheduler_.RegainWorker(1);
  clock_.Advance(absl::Seconds(5));
  EXPECT_TRUE(scheduler_.Expire().workers.empty());
  EXPECT_EQ(scheduler_.LeasedTiles(1), 1);
}

TEST_F(TileSchedulerTest, SilentWorkerGetsNothing) {
  scheduler_.AddJob(1, 1, 2, 1);
  scheduler_.AddWorker(1, "a", 1);
  clock_.Advance(absl::Seconds(15));
  EXPECT_FALSE(scheduler_.Grant(1).has_value());
  scheduler_.Renew(1, {});
  EXPECT_TRUE(scheduler_.Grant(1).has_value());
}

TEST_F(TileSchedulerTest, WorkersSpreadOverFramesStayThereAndJoinWhenFramesRunOut) {
  scheduler_.AddJob(1, 2, 4, 4);
  for (WorkerId id = 1; id <= 3; ++id) scheduler_.AddWorker(id, absl::StrCat(id), 1);
  EXPECT_EQ(scheduler_.Grant(1)->frame, 0);
  EXPECT_EQ(scheduler_.Grant(2)->frame, 1);
  EXPECT_EQ(scheduler_.Grant(1)->frame, 0);
  EXPECT_EQ(scheduler_.Grant(2)->frame, 1);
  EXPECT_EQ(scheduler_.Grant(2)->frame, 1);
  EXPECT_EQ(scheduler_.Grant(3)->frame, 0);  // 14 tiles queued there, 13 in the other.
  for (int i = 0; i < 13; ++i) EXPECT_EQ(scheduler_.Grant(3)->frame, 0);
  EXPECT_EQ(scheduler_.Grant(1)->frame, 1);
}

TEST_F(TileSchedulerTest, OlderJobOfOneUserComesFirst) {
  scheduler_.AddJob(7, 1, 1, 1);
  scheduler_.AddJob(3, 1, 1, 1);
  scheduler_.AddWorker(1, "a", 1);
  EXPECT_EQ(scheduler_.Grant(1)->job, 3u);
  EXPECT_EQ(scheduler_.Grant(1)->job, 7u);
  EXPECT_FALSE(scheduler_.Grant(1).has_value());
}

TEST_F(TileSchedulerTest, LateResultOfAnExpiredLeaseCountsOnceAndFreesTheNewOne) {
  scheduler_.AddJob(1, 1, 1, 1);
  scheduler_.AddWorker(1, "a", 1);
  scheduler_.AddWorker(2, "b", 1);
  ASSERT_TRUE(scheduler_.Grant(1).has_value());
  clock_.Advance(absl::Seconds(15));
  scheduler_.Renew(2, {});
  scheduler_.Expire();
  ASSERT_TRUE(scheduler_.Grant(2).has_value());
  EXPECT_TRUE(scheduler_.Complete(1, 0, 0, 1, absl::Seconds(20)));
  EXPECT_EQ(scheduler_.LeasedTiles(2), 0);
  EXPECT_FALSE(scheduler_.Complete(1, 0, 0, 2, absl::Seconds(1)));
  EXPECT_EQ(scheduler_.Find(1)->remaining(), 0);
}

TEST_F(TileSchedulerTest, TileThatALoneWorkerFailsThreeTimesIsQuarantinedWithEvidence) {
  scheduler_.AddJob(1, 1, 2, 1);
  scheduler_.AddWorker(1, "a", 1, "boot", "host a");
  const uint32_t bad = scheduler_.Grant(1)->tiles[0];
  std::optional<Quarantined> quarantined;
  for (int i = 1; i <= 3; ++i) {
    quarantined = scheduler_.Fail(1, 0, bad, 1, absl::StrCat("no memory ", i));
    ASSERT_EQ(quarantined.has_value(), i == 3);
    // What came back comes first, until it is given up.
    if (i < 3) {
      ASSERT_EQ(scheduler_.Grant(1)->tiles, std::vector<uint32_t>{bad});
    }
  }
  EXPECT_EQ(quarantined->tile, bad);
  ASSERT_EQ(quarantined->evidence.size(), 3u);
  EXPECT_EQ(quarantined->evidence[2], (TileTrouble{"a", "host a", false, "no memory 3", clock_.Wall()}));
  Finish(*scheduler_.Grant(1), absl::Seconds(1));
  EXPECT_EQ(scheduler_.Find(1)->remaining(), 0);
  EXPECT_EQ(scheduler_.Find(1)->quarantined(), 1);
  EXPECT_FALSE(scheduler_.Complete(1, 0, bad, 1, absl::Seconds(1)));  // Final, until it is released.
  EXPECT_EQ(scheduler_.Find(1)->Release(), (std::vector<std::pair<int, uint32_t>>{{0, bad}}));
  Finish(*scheduler_.Grant(1), absl::Seconds(1));
  EXPECT_EQ(scheduler_.Find(1)->DoneInFrame(0), 2);
}

TEST_F(TileSchedulerTest, WhatAWorkerHasFailedGoesToAnotherThatAsksForWork) {
  scheduler_.AddJob(1, 1, 2, 1);
  scheduler_.AddWorker(1, "a", 1);
  scheduler_.AddWorker(2, "b", 1);
  const uint32_t bad = scheduler_.Grant(1)->tiles[0];
  const Lease other = *scheduler_.Grant(2);
  EXPECT_FALSE(scheduler_.Fail(1, 0, bad, 1, "broken disk").has_value());
  EXPECT_FALSE(scheduler_.Fail(1, 0, bad, 1, "again, unasked").has_value());  // It holds the tile no longer.
  EXPECT_FALSE(scheduler_.Fail(1, 0, bad, 1, "again, unasked").has_value());
  EXPECT_FALSE(scheduler_.Grant(1).has_value());
  Finish(other, absl::Seconds(1));
  EXPECT_EQ(scheduler_.Grant(2)->tiles, std::vector<uint32_t>{bad});
  EXPECT_FALSE(scheduler_.Fail(1, 0, bad, 2, "too").has_value());
  EXPECT_TRUE(scheduler_.Grant(1).has_value());  // Both have failed it: it is anybody's.
}

TEST_F(TileSchedulerTest, WorkerThatFailsThreeTilesOfAJobGetsNoMoreOfItWhileOthersWould) {
  scheduler_.AddJob(1, 1, 8, 8);
  scheduler_.AddWorker(1, "broken", 1);
  scheduler_.AddWorker(2, "good", 1);
  std::vector<Lease> good = {*scheduler_.Grant(2)};
  for (int i = 0; i < 3; ++i) {
    const Lease lease = *scheduler_.Grant(1);
    ASSERT_EQ(lease.job, 1u);
    EXPECT_FALSE(scheduler_.Fail(1, 0, lease.tiles[0], 1, "no such instruction").has_value());
  }
  EXPECT_FALSE(scheduler_.Grant(1).has_value());
  scheduler_.AddJob(2, 1, 1, 1);
  EXPECT_EQ(scheduler_.Grant(1)->job, 2u);  // Another job is another matter.
  EXPECT_FALSE(scheduler_.Grant(1).has_value());
  scheduler_.RemoveWorker(2);
  EXPECT_EQ(scheduler_.Grant(1)->job, 1u);  // Nobody else is left.
}

TEST_F(TileSchedulerTest, CrashLoopingWorkerBlamesOnlyWhatItRenderedAndQuarantinesNothingAlone) {
  scheduler_.AddJob(1, 1, 8, 8);
  Finish((scheduler_.AddWorker(1, "good", 1), *scheduler_.Grant(1)), absl::Milliseconds(25));
  // One machine that crashes and comes back, nine times: it is one and the same.
  for (WorkerId id = 10; id < 19; ++id) {
    scheduler_.AddWorker(id, "crashing", 1, absl::StrCat("boot ", id));
    ASSERT_TRUE(scheduler_.Grant(id).has_value());
    if (id % 2 == 0) {
      scheduler_.LoseWorker(id);
      clock_.Advance(absl::Seconds(1));
      scheduler_.Renew(1, {});
      EXPECT_TRUE(scheduler_.Expire().quarantined.empty());
    } else {
      EXPECT_TRUE(scheduler_.BuryWorker(id).empty());
    }
  }
  while (const std::optional<Lease> lease = scheduler_.Grant(1)) Finish(*lease, absl::Milliseconds(25));
  EXPECT_EQ(scheduler_.Find(1)->remaining(), 0);
}

TEST_F(TileSchedulerTest, LoneWorkerThatDiesOfATileTenTimesIsSparedTheEleventh) {
  scheduler_.AddJob(1, 1, 1, 1);
  for (WorkerId id = 1; id <= 10; ++id) {
    scheduler_.AddWorker(id, "alone", 1, absl::StrCat("boot ", id));
    ASSERT_TRUE(scheduler_.Grant(id).has_value());
    EXPECT_EQ(scheduler_.BuryWorker(id).size(), id == 10 ? 1u : 0u);
  }
}

TEST_F(TileSchedulerTest, TileThatKillsThreeWorkersIsQuarantinedAndLeasedAloneBefore) {
  scheduler_.AddJob(1, 1, 8, 8);
  Finish((scheduler_.AddWorker(1, "good", 1), *scheduler_.Grant(1)), absl::Milliseconds(25));
  std::vector<Quarantined> quarantined;
  uint32_t suspect = 0;
  for (int death = 1; death <= 3; ++death) {
    const WorkerId id = WorkerId(10 + death);
    scheduler_.AddWorker(id, absl::StrCat("w", death), 1);
    const std::optional<Lease> lease = scheduler_.Grant(id);
    ASSERT_TRUE(lease.has_value());
    if (death == 1) suspect = lease->tiles[0];
    if (death > 1) {
      EXPECT_EQ(lease->tiles, std::vector<uint32_t>{suspect});
    }
    scheduler_.LoseWorker(id);
    clock_.Advance(absl::Seconds(1));
    quarantined = scheduler_.Expire().quarantined;
    EXPECT_EQ(quarantined.size(), death == 3 ? 1u : 0u);
  }
  ASSERT_EQ(quarantined.size(), 1u);
  EXPECT_EQ(quarantined[0].tile, suspect);
  ASSERT_EQ(quarantined[0].evidence.size(), 3u);
  EXPECT_TRUE(quarantined[0].evidence[1].worker_ended);
  EXPECT_EQ(quarantined[0].evidence[1].worker_uuid, "w2");
}

TEST_F(TileSchedulerTest, WorkerThatComesBackWasNotKilled) {
  scheduler_.AddJob(1, 1, 1, 1);
  for (WorkerId id = 1; id <= 9; id += 3) {
    // A network that flaps: three workers are cut off at the same tile, and come back.
    for (WorkerId worker = id; worker < id + 3; ++worker) {
      const std::string name = absl::StrCat("w", worker - id);
      scheduler_.AddWorker(worker, name, 1, name + " boot");
    }
    ASSERT_TRUE(scheduler_.Grant(id + id / 3).has_value());
    for (WorkerId worker = id; worker < id + 3; ++worker) scheduler_.LoseWorker(worker);
    clock_.Advance(absl::Seconds(1));
    EXPECT_TRUE(scheduler_.Expire().quarantined.empty());
  }
}

TEST_F(TileSchedulerTest, WhatAProcessWasAtIsSuspectAndNothingElse) {
  scheduler_.AddJob(1, 1, 8, 8);
  scheduler_.AddWorker(1, "w", 1, "boot 1", "host");
  std::vector<Lease> leases;
  for (int i = 0; i < 3; ++i) leases.push_back(*scheduler_.Grant(1));
  // Not that of the oldest lease: its frame was being made ready elsewhere, say. And one that it does not
  // hold.
  WorkerEnd end{{"boot 1", "SIGBUS", "tail"}, {{1, 0, leases[1].tiles[0]}, {1, 0, 63}}};
  EXPECT_TRUE(scheduler_.BuryWorker(1, &end).empty());
  const JobQueue& queue = *scheduler_.Find(1);
  EXPECT_EQ(queue.TroublesOf(0, leases[0].tiles[0]), nullptr);
  EXPECT_EQ(queue.TroublesOf(0, 63), nullptr);
  const TroubleLog* log = queue.TroublesOf(0, leases[1].tiles[0]);
  ASSERT_NE(log, nullptr);
  EXPECT_TRUE(log->suspect());
  EXPECT_EQ(log->evidence[0],
            (TileTrouble{"w", "host", true, "its process ended while it rendered the tile: SIGBUS",
                         clock_.Wall(), "SIGBUS", "tail", "boot 1"}));
  EXPECT_EQ(queue.remaining(), 64);
}

TEST_F(TileSchedulerTest, WorkerThatBringsNothingBackOfAJobComesToOthers) {
  scheduler_.AddJob(1, 1, 100, 10, 5);
  scheduler_.AddJob(2, 1, 100, 10);
  scheduler_.AddWorker(1, "a", 2);
  for (int i = 0; i < 32; ++i) EXPECT_EQ(scheduler_.Grant(1)->job, 1u);
  const Lease other = *scheduler_.Grant(1);
  EXPECT_EQ(other.job, 2u) << "though the first job comes before it";
  Finish(other, absl::Milliseconds(25));
  EXPECT_EQ(scheduler_.Grant(1)->job, 2u);
  scheduler_.AddWorker(2, "b", 1);
  EXPECT_EQ(scheduler_.Grant(2)->job, 1u) << "the first job has tiles for who can render them";
}

TEST_F(TileSchedulerTest, LateWordAcquitsWhatAProcessWasNotAt) {
  scheduler_.AddJob(1, 1, 8, 8);
  scheduler_.AddWorker(1, "w", 2, "boot 1");
  const Lease a = *scheduler_.Grant(1), b = *scheduler_.Grant(1);
  scheduler_.LoseWorker(1);
  clock_.Advance(absl::Seconds(1));
  scheduler_.Expire();
  const JobQueue& queue = *scheduler_.Find(1);
  ASSERT_TRUE(queue.TroublesOf(0, a.tiles[0])->suspect());
  ASSERT_TRUE(queue.TroublesOf(0, b.tiles[0])->suspect());
  scheduler_.Testify("w", {{"boot 2", "SIGBUS", "of another process"}, {}});
  scheduler_.Testify("v", {{"boot 1", "SIGBUS", "of another worker"}, {}});
  EXPECT_TRUE(queue.TroublesOf(0, a.tiles[0])->suspect());
  for (int times = 0; times < 2; ++times) {
    scheduler_.Testify("w", {{"boot 1", "SIGSEGV", "tail"}, {{1, 0, b.tiles[0]}}});
    EXPECT_FALSE(queue.TroublesOf(0, a.tiles[0])->suspect());
    EXPECT_EQ(queue.TroublesOf(0, a.tiles[0])->deaths, 0);
    const TroubleLog& log = *queue.TroublesOf(0, b.tiles[0]);
    EXPECT_TRUE(log.suspect());
    ASSERT_EQ(log.evidence.size(), 1u);
    EXPECT_EQ(log.evidence[0].signal, "SIGSEGV");
    EXPECT_EQ(log.evidence[0].log_tail, "tail");
  }
}

TEST_F(TileSchedulerTest, LateWordOfATileThatNobodyHoldsForTheDeathAcquitsNone) {
  scheduler_.AddJob(1, 1, 8, 8);
  scheduler_.AddJob(2, 1, 1, 1);
  scheduler_.AddWorker(1, "w", 1, "boot 1");
  const Lease lease = *scheduler_.Grant(1);
  scheduler_.LoseWorker(1);
  clock_.Advance(absl::Seconds(1));
  scheduler_.Expire();
  const JobQueue& queue = *scheduler_.Find(1);
  const WorkerEnd end{{"boot 1", "SIGSEGV", ""}, {{2, 0, 0}}};
  scheduler_.Testify("w", end);
  EXPECT_TRUE(queue.TroublesOf(0, lease.tiles[0])->suspect()) << "who else is to answer for it?";
  scheduler_.AddWorker(2, "v", 1);
  scheduler_.Complete(2, 0, 0, 2, absl::Milliseconds(1));
  scheduler_.Testify("w", end);
  EXPECT_FALSE(queue.TroublesOf(0, lease.tiles[0])->suspect()) << "the other tile does not kill workers";
}

TEST_F(TileSchedulerTest, RemovedJobEndsItsLeasesAndIgnoresResults) {
  scheduler_.AddJob(1, 1, 1, 1);
  scheduler_.AddWorker(1, "a", 1);
  const Lease lease = *scheduler_.Grant(1);
  const std::vector<EndedLease> ended = scheduler_.RemoveJob(1);
  ASSERT_EQ(ended.size(), 1u);
  EXPECT_EQ(ended[0].id, lease.id);
  EXPECT_FALSE(scheduler_.Complete(1, 0, 0, 1, absl::Seconds(1)));
  EXPECT_FALSE(scheduler_.Fail(1, 0, 0, 1, "late").has_value());
}

TEST_F(TileSchedulerTest, LostPixelsAreRenderedAgain) {
  scheduler_.AddJob(1, 1, 2, 2);
  scheduler_.AddWorker(1, "a", 1);
  while (const std::optional<Lease> lease = scheduler_.Grant(1)) Finish(*lease, absl::Seconds(1));
  scheduler_.Find(1)->Reopen(0, {2});
  const std::optional<Lease> again = scheduler_.Grant(1);
  ASSERT_TRUE(again.has_value());
  EXPECT_EQ(again->tiles, std::vector<uint32_t>{2});
  Finish(*again, absl::Seconds(1));
  EXPECT_EQ(scheduler_.Find(1)->remaining(), 0);
}

/// Workers come, go, stall, fail and die at random; whatever happens, every tile is counted once, no tile has
/// two holders, and the job ends.
TEST(TileSchedulerPropertyTest, EachTileIsDoneExactlyOnceUnderRandomSchedules) {
  for (uint32_t seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937 random(seed);
    const auto below = [&](int n) { return int(random() % uint32_t(n)); };
    FakeClock clock;
    SchedulerOptions options;
    options.max_tile_failures = 1'000'000;
    options.max_tile_deaths = options.max_deaths_at_all = 1'000'000;
    TileScheduler scheduler(clock, options);
    const int frames = 1 + below(4), columns = 1 + below(6), rows = 1 + below(6);
    scheduler.AddJob(1, frames, columns, rows);
    std::map<WorkerId, std::vector<Lease>> workers;  // Leases that each believes it holds.
    std::set<std::tuple<int, uint32_t>> done;
    WorkerId next = 1;
    int steps = 0;
    while (scheduler.Find(1)->remaining() > 0) {
      ASSERT_LT(++steps, 200'000) << "the job does not end";
      if (workers.empty() || below(40) == 0) {
        scheduler.AddWorker(next, absl::StrCat(next), 1 + below(3));
        workers[next++];
      }
      auto worker = std::next(workers.begin(), below(int(workers.size())));
      auto& [id, leases] = *worker;
      switch (below(8)) {
        case 0:
        case 1:
          if (const std::optional<Lease> lease = scheduler.Grant(id)) leases.push_back(*lease);
          break;
        case 2:
        case 3:
        case 4: {
          if (leases.empty()) break;
          const Lease lease = leases[size_t(below(int(leases.size())))];
          const uint32_t tile = lease.tiles[size_t(below(int(lease.tiles.size())))];
          const bool is_new = scheduler.Complete(1, lease.frame, tile, id, absl::Milliseconds(below(200)));
          ASSERT_EQ(is_new, done.insert({lease.frame, tile}).second);
          break;
        }
        case 5: {
          if (leases.empty()) break;
          const Lease lease = leases.back();
          scheduler.Fail(1, lease.frame, lease.tiles[0], id, "chance");
          break;
        }
        case 6: {
          clock.Advance(absl::Milliseconds(below(4000)));
          std::vector<LeaseId> named;
          for (const Lease& lease : leases) named.push_back(lease.id);
          scheduler.Renew(id, named);
          const TileScheduler::Expired expired = scheduler.Expire();
          for (const WorkerId gone : expired.workers) workers.erase(gone);
          break;
        }
        case 7:
          if (below(4) == 0) {
            scheduler.LoseWorker(id);
          } else if (below(4) == 0) {
            scheduler.RemoveWorker(id);
            workers.erase(worker);
          } else if (!leases.empty()) {
            scheduler.Return(id, {leases.back().id});
          }
          break;
      }
      int64_t leased = 0;
      for (const auto& [other, unused] : workers) leased += scheduler.LeasedTiles(other);
      ASSERT_EQ(leased + scheduler.QueuedTiles(), scheduler.Find(1)->remaining());
    }
    EXPECT_EQ(done.size(), size_t(frames * columns * rows));
  }
}

}  // namespace
}  // namespace shutterline::server
