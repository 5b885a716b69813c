// The scheduler under a thousand random histories: workers join, leave, crash, flap, fall silent and fail;
// results come late, twice or never; jobs are paused, cancelled and moved; the coordinator starts anew.
// Whatever happens, the invariants below hold after every step, and once the faults end so does every job.
//
// SHUTTERLINE_HISTORIES=N runs N histories, SHUTTERLINE_HISTORY=SEED one.
#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <map>
#include <memory>
#include <random>
#include <set>
#include <tuple>

#include "server/schedule/tile_scheduler.h"
#include "tests/support/fake_clock.h"

namespace shutterline::server {
namespace {

using TileKey = std::tuple<JobKey, int, uint32_t>;

/// What happened over all histories: what never happens is not tested.
struct Seen {
  int copies = 0, adopted = 0, quarantined = 0, restarts = 0, revoked = 0, dropped = 0;
};

class History {
 public:
  History(uint32_t seed, Seen& seen) : random_(seed), seen_(seen) {
    options_.max_tile_failures = 3;
    scheduler_ = std::make_unique<TileScheduler>(clock_, options_);
    const int jobs = 1 + Below(4);
    for (int i = 0; i < jobs; ++i) {
      Job job;
      job.frames = 1 + Below(2);
      job.columns = 1 + Below(5);
      job.rows = 1 + Below(4);
      job.priority = Below(3) == 0 ? 1 : 0;
      job.user = Below(2) == 0 ? "ann" : "bob";
      job.order = TileOrder(Below(3));
      jobs_[JobKey(i + 1)] = job;
    }
    ScheduleJobs();
  }

  void Run() {
    const int steps = 100 + Below(300);
    for (int i = 0; i < steps && !testing::Test::HasFatalFailure(); ++i) {
      Step();
      Pump();
      Check();
    }
    if (!testing::Test::HasFatalFailure()) Heal();
  }

 private:
  struct Job {
    int frames = 0, columns = 0, rows = 0, priority = 0;
    std::string user;
    TileOrder order = TileOrder::kHilbert;
    bool paused = false, cancelled = false;
  };
  struct Worker {
    std::string uuid, boot;
    int slots = 1, credit = 0;
    bool lost = false;                ///< Its stream is broken; the process may live.
    bool silent = false;              ///< It sends no heartbeats.
    std::map<LeaseId, Lease> leases;  ///< That it believes to hold.
  };
  struct Result {
    JobKey job = 0;
    int frame = 0;
    uint32_t tile = 0;
    WorkerId worker = 0;
    absl::Duration time;
  };

  int Below(int n) { return int(random_() % uint32_t(n)); }

  void ScheduleJobs() {
    for (const auto& [key, job] : jobs_) {
      if (job.cancelled) continue;
      scheduler_->AddJob(key, job.frames, job.columns, job.rows, job.priority, job.user, job.order);
      scheduler_->SetBlocked(key, TileScheduler::Block::kPaused, job.paused);
      JobQueue& queue = *scheduler_->Find(key);
      for (const auto& [tile_job, frame, tile] : quarantined_) {
        if (tile_job == key) queue.Quarantine(frame, tile);
      }
      for (const auto& [tile, unused] : done_) {
        if (std::get<0>(tile) == key) queue.MarkDone(std::get<1>(tile), std::get<2>(tile));
      }
    }
  }

  std::pair<const WorkerId, Worker>* AnyWorker() {
    if (workers_.empty()) return nullptr;
    return &*std::next(workers_.begin(), Below(int(workers_.size())));
  }
  Job& AnyJob(JobKey& key) {
    const auto job = std::next(jobs_.begin(), Below(int(jobs_.size())));
    key = job->first;
    return job->second;
  }

  void Join(const std::string& uuid, const std::string& boot, int slots) {
    const WorkerId id = next_worker_++;
    Worker& worker = workers_[id];
    worker.uuid = uuid;
    worker.boot = boot;
    worker.slots = slots;
    worker.credit = 3 * slots;
    scheduler_->AddWorker(id, uuid, slots, boot, uuid);
  }

  /// The same process registers again and says what it holds.
  void ComeBack(WorkerId id) {
    Worker old = workers_.at(id);
    scheduler_->RemoveWorker(id);
    workers_.erase(id);
    Join(old.uuid, old.boot, old.slots);
    Reclaim(next_worker_ - 1, old);
  }
  void Reclaim(WorkerId id, const Worker& old) {
    Worker& worker = workers_.at(id);
    for (const auto& [lease_id, lease] : old.leases) {
      if (const auto adopted = scheduler_->Adopt(id, lease.job, lease.frame, lease.tiles)) {
        for (const uint32_t tile : adopted->tiles) {
          ASSERT_NE(std::find(lease.tiles.begin(), lease.tiles.end(), tile), lease.tiles.end());
        }
        worker.leases[adopted->id] = *adopted;
        owner_[adopted->id] = id;
        ++seen_.adopted;
      }
    }
  }

  void Restart() {
    ++seen_.restarts;
    // Unacknowledged results travel again to the new coordinator; it knows none of the old leases.
    scheduler_ = std::make_unique<TileScheduler>(clock_, options_);
    owner_.clear();
    ScheduleJobs();
    const std::map<WorkerId, Worker> before = std::exchange(workers_, {});
    for (const auto& [id, old] : before) {
      if (old.lost && Below(2) == 0) continue;
      Join(old.uuid, old.boot, old.slots);
      Reclaim(next_worker_ - 1, old);
    }
  }

  void Quarantine(const Quarantined& tile) {
    ++seen_.quarantined;
    ASSERT_FALSE(tile.evidence.empty());
    ASSERT_FALSE(done_.contains({tile.job, tile.frame, tile.tile}));
    ASSERT_TRUE(quarantined_.insert({tile.job, tile.frame, tile.tile}).second);
  }

  void Tick(absl::Duration time) {
    clock_.Advance(time);
    for (auto& [id, worker] : workers_) {
      if (worker.silent || worker.lost) continue;
      std::vector<LeaseId> named;
      for (const auto& [lease, unused] : worker.leases) named.push_back(lease);
      scheduler_->Renew(id, named);
    }
    const TileScheduler::Expired expired = scheduler_->Expire();
    for (const EndedLease& lease : expired.leases) {
      if (workers_.contains(lease.worker)) workers_.at(lease.worker).leases.erase(lease.id);
    }
    for (const WorkerId id : expired.workers) {
      guilty_.insert(workers_.at(id).uuid);
      workers_.erase(id);
    }
    for (const Quarantined& tile : expired.quarantined) Quarantine(tile);
  }

  void Deliver(const Result& result) {
    const TileKey key{result.job, result.frame, result.tile};
    const bool wanted =
        !jobs_.at(result.job).cancelled && !done_.contains(key) && !quarantined_.contains(key);
    ASSERT_EQ(scheduler_->Complete(result.job, result.frame, result.tile, result.worker, result.time),
              wanted);
    if (wanted) done_[key] = workers_.contains(result.worker) ? workers_.at(result.worker).uuid : "";
    for (const EndedLease& lease : scheduler_->TakeRevoked()) {
      ++seen_.revoked;
      if (workers_.contains(lease.worker)) workers_.at(lease.worker).leases.erase(lease.id);
    }
    for (const DroppedTile& dropped : scheduler_->TakeDropped()) {
      ++seen_.dropped;
      ASSERT_EQ(dropped.tile, result.tile);
      ASSERT_NE(dropped.worker, result.worker);
      Worker& worker = workers_.at(dropped.worker);
      const auto lease = worker.leases.find(dropped.lease);
      if (lease == worker.leases.end()) continue;  // It has rendered all of it, and waits for the answers.
      std::erase(lease->second.tiles, dropped.tile);
      if (!lease->second.tiles.empty()) continue;
      worker.leases.erase(lease);
      ++worker.credit;
    }
  }

  /// The worker renders the next tile of one of its leases: the result is under way.
  void Render(WorkerId id, Worker& worker) {
    if (worker.leases.empty()) return;
    const auto lease = std::next(worker.leases.begin(), Below(int(worker.leases.size())));
    std::vector<uint32_t>& tiles = lease->second.tiles;
    if (Below(4) == 0) {
      guilty_.insert(worker.uuid);
      const auto hopeless =
          scheduler_->Fail(lease->second.job, lease->second.frame, tiles.front(), id, "chance");
      if (hopeless) Quarantine(*hopeless);
    } else {
      const Result result{lease->second.job, lease->second.frame, tiles.front(), id,
                          absl::Milliseconds(Below(2000))};
      if (Below(10) != 0) under_way_.push_back(result);  // Else the report is lost.
      if (Below(6) == 0) under_way_.push_back(result);   // Or comes twice.
    }
    tiles.erase(tiles.begin());
    if (tiles.empty()) {
      worker.leases.erase(lease);  // No heartbeat names it any more.
      ++worker.credit;
    }
  }

  void Step() {
    auto* any = AnyWorker();
    if (any == nullptr || Below(30) == 0) {
      const std::string name = absl::StrCat("w", Below(8));
      for (const auto& [id, worker] : workers_) {
        if (worker.uuid == name) return;
      }
      return Join(name, absl::StrCat(name, " boot ", next_worker_), 1 + Below(3));
    }
    auto& [id, worker] = *any;
    switch (Below(16)) {
      case 0:
      case 1:
      case 2:
      case 3:
        if (!worker.lost) Render(id, worker);
        return;
      case 4:
      case 5:
      case 6: {
        if (under_way_.empty()) return;
        std::swap(under_way_[size_t(Below(int(under_way_.size())))], under_way_.back());
        const Result result = under_way_.back();
        under_way_.pop_back();
        return Deliver(result);
      }
      case 7:
      case 8:
        return Tick(absl::Milliseconds(Below(3000)));
      case 9:
        if (Below(3) == 0) worker.silent = !worker.silent;
        return;
      case 10:
        if (Below(3) != 0) return;
        if (worker.lost) return ComeBack(id);
        worker.lost = true;
        return scheduler_->LoseWorker(id);
      case 11: {
        if (Below(4) != 0) return;
        // The process dies and starts again at once.
        const Worker old = worker;
        guilty_.insert(old.uuid);
        for (const Quarantined& tile : scheduler_->BuryWorker(id)) Quarantine(tile);
        workers_.erase(id);
        return Join(old.uuid, absl::StrCat(old.uuid, " boot ", next_worker_), old.slots);
      }
      case 12:
        if (Below(3) != 0) return;
        scheduler_->RemoveWorker(id);
        workers_.erase(id);
        return;
      case 13: {
        JobKey key = 0;
        Job& job = AnyJob(key);
        if (job.cancelled || Below(2) != 0) return;
        job.paused = !job.paused;
        scheduler_->SetBlocked(key, TileScheduler::Block::kPaused, job.paused);
        if (job.paused) Revoke(scheduler_->EndLeases(key));
        return;
      }
      case 14: {
        JobKey key = 0;
        Job& job = AnyJob(key);
        if (Below(10) == 0 && !job.cancelled) {
          job.cancelled = true;
          Revoke(scheduler_->RemoveJob(key));
        } else if (!job.cancelled) {
          job.priority = Below(3);
          scheduler_->SetPriority(key, job.priority);
        }
        return;
      }
      case 15:
        if (Below(12) == 0) Restart();
        return;
    }
  }

  void Revoke(const std::vector<EndedLease>& ended) {
    for (const EndedLease& lease : ended) {
      if (workers_.contains(lease.worker)) workers_.at(lease.worker).leases.erase(lease.id);
    }
  }

  bool IsReady(const Worker& worker) const { return !worker.lost && !worker.silent; }

  /// As the farm's: whoever wants work gets what there is.
  void Pump() {
    for (auto& [id, worker] : workers_) {
      if (IsReady(worker)) scheduler_->Renew(id, {});
    }
    bool granted = true;
    while (granted) {
      granted = false;
      for (auto& [id, worker] : workers_) {
        if (!IsReady(worker) || worker.credit == 0) continue;
        int highest = -1;
        for (const auto& [key, job] : jobs_) {
          const JobQueue* queue = scheduler_->Find(key);
          if (queue != nullptr && !job.paused && queue->queued() > 0)
            highest = std::max(highest, job.priority);
        }
        const std::optional<Lease> lease = scheduler_->Grant(id);
        if (!lease) {
          // Only what it has failed itself may wait while a worker has credit.
          ASSERT_TRUE(highest == -1 || guilty_.contains(worker.uuid)) << "tiles wait for " << worker.uuid;
          continue;
        }
        ASSERT_TRUE(guilty_.contains(worker.uuid) || jobs_.at(lease->job).priority == highest);
        Enter(id, worker, *lease);
        granted = true;
      }
    }
    if (scheduler_->QueuedTiles() > 0) return;
    std::vector<WorkerId> idle;
    for (const auto& [id, worker] : workers_) {
      if (IsReady(worker) && worker.credit > 0) idle.push_back(id);
    }
    for (const Lease& copy : scheduler_->Speculate(idle)) {
      ++seen_.copies;
      Enter(copy.worker, workers_.at(copy.worker), copy);
    }
  }

  void Enter(WorkerId id, Worker& worker, const Lease& lease) {
    ASSERT_FALSE(owner_.contains(lease.id)) << "a lease's number is used again";
    ASSERT_FALSE(lease.tiles.empty());
    ASSERT_FALSE(jobs_.at(lease.job).paused || jobs_.at(lease.job).cancelled);
    for (const uint32_t tile : lease.tiles) {
      ASSERT_FALSE(done_.contains({lease.job, lease.frame, tile}));
      ASSERT_FALSE(quarantined_.contains({lease.job, lease.frame, tile}));
    }
    worker.leases[lease.id] = lease;
    owner_[lease.id] = id;
    --worker.credit;
  }

  void Check() const {
    int64_t held = 0, leased = 0;
    for (const auto& [id, worker] : workers_) leased += scheduler_->LeasedTiles(id);
    for (const auto& [key, job] : jobs_) {
      const JobQueue* queue = scheduler_->Find(key);
      ASSERT_EQ(queue == nullptr, job.cancelled);
      if (queue == nullptr) continue;
      int64_t remaining = 0, queued = 0;
      for (int frame = 0; frame < job.frames; ++frame) {
        for (uint32_t tile = 0; tile < uint32_t(job.columns * job.rows); ++tile) {
          const bool done = done_.contains({key, frame, tile});
          const bool quarantined = quarantined_.contains({key, frame, tile});
          ASSERT_EQ(queue->IsDone(frame, tile), done);
          ASSERT_EQ(queue->IsQuarantined(frame, tile), quarantined);
          const Holders holders = queue->HoldersOf(frame, tile);
          if (done || quarantined) {
            ASSERT_EQ(holders.first, 0u);
            continue;
          }
          ++remaining;
          if (holders.first == 0) ++queued;
          held += (holders.first != 0 ? 1 : 0) + (holders.second != 0 ? 1 : 0);
          if (holders.second != 0) {
            ASSERT_NE(workers_.at(owner_.at(holders.first)).uuid,
                      workers_.at(owner_.at(holders.second)).uuid);
          }
          for (const LeaseId holder : {holders.first, holders.second}) {
            ASSERT_TRUE(holder == 0 || workers_.contains(owner_.at(holder))) << "held by nobody";
          }
        }
      }
      ASSERT_EQ(queue->remaining(), remaining);
      ASSERT_EQ(queue->queued(), queued);
    }
    ASSERT_EQ(leased, held) << "a worker has a lease of a tile that it does not hold";
    // Nobody goes on with what somebody else has delivered.
    for (const auto& [id, worker] : workers_) {
      for (const auto& [lease_id, lease] : worker.leases) {
        for (const uint32_t tile : lease.tiles) {
          const auto done = done_.find({lease.job, lease.frame, tile});
          ASSERT_TRUE(done == done_.end() || done->second == worker.uuid);
        }
      }
    }
  }

  /// No more faults, and a good worker: every job ends.
  void Heal() {
    for (auto& [key, job] : jobs_) {
      job.paused = false;
      if (!job.cancelled) scheduler_->SetBlocked(key, TileScheduler::Block::kPaused, false);
    }
    Join("good", "good boot", 2);
    const WorkerId good = next_worker_ - 1;
    for (int step = 0; step < 2000; ++step) {
      int64_t remaining = 0;
      for (const auto& [key, job] : jobs_)
        remaining += job.cancelled ? 0 : scheduler_->Find(key)->remaining();
      if (remaining == 0) return;
      Tick(absl::Seconds(1));
      Pump();
      // Others hold on to what they have and render nothing.
      Worker& worker = workers_.at(good);
      while (!worker.leases.empty()) {
        const Lease lease = worker.leases.begin()->second;
        worker.leases.erase(worker.leases.begin());
        ++worker.credit;
        for (const uint32_t tile : lease.tiles) {
          Deliver({lease.job, lease.frame, tile, good, absl::Milliseconds(100)});
        }
      }
      for (auto& [id, other] : workers_) {
        if (id != good) other.silent = true;
      }
      Check();
    }
    FAIL() << "a job does not end";
  }

  std::mt19937 random_;
  Seen& seen_;
  test::FakeClock clock_;
  SchedulerOptions options_;
  std::unique_ptr<TileScheduler> scheduler_;
  std::map<JobKey, Job> jobs_;
  std::map<WorkerId, Worker> workers_;
  std::map<LeaseId, WorkerId> owner_;  ///< Of the current scheduler's leases.
  std::vector<Result> under_way_;
  std::map<TileKey, std::string> done_;  ///< And by whom: a UUID, or nothing where he is gone.
  std::set<TileKey> quarantined_;
  std::set<std::string> guilty_;  ///< Workers that have failed tiles, or died.
  WorkerId next_worker_ = 1;
};

int64_t FromEnvironment(const char* name, int64_t otherwise) {
  int64_t value = otherwise;
  const char* text = std::getenv(name);
  EXPECT_TRUE(text == nullptr || absl::SimpleAtoi(text, &value)) << name;
  return value;
}

TEST(RandomHistoryTest, EveryTileIsDoneOnceNothingIsHeldByTheLostAndNobodyWaitsInVain) {
  const int64_t one = FromEnvironment("SHUTTERLINE_HISTORY", 0);
  const int64_t first = one > 0 ? one : 1;
  const int64_t last = one > 0 ? one : FromEnvironment("SHUTTERLINE_HISTORIES", 1000);
  Seen seen;
  for (int64_t seed = first; seed <= last; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    History(uint32_t(seed), seen).Run();
    if (HasFatalFailure()) return;
  }
  if (last - first < 999) return;
  for (const int count :
       {seen.copies, seen.adopted, seen.quarantined, seen.restarts, seen.revoked, seen.dropped}) {
    EXPECT_GT(count, 20) << "copies " << seen.copies << " adopted " << seen.adopted << " quarantined "
                         << seen.quarantined << " restarts " << seen.restarts << " revoked " << seen.revoked
                         << " dropped " << seen.dropped;
  }
}

}  // namespace
}  // namespace shutterline::server
