#pragma once

#include <absl/container/flat_hash_map.h>
#include <absl/time/time.h>

#include <algorithm>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "common/base/clock.h"
#include "server/schedule/fair_share.h"
#include "server/schedule/job_queue.h"
#include "server/schedule/lease.h"
#include "server/schedule/tile_times.h"

namespace shutterline::server {

/// How a worker's process ended, and what it was at.
struct WorkerEnd {
  ProcessEnd process;
  struct Tile {
    JobKey job = 0;
    int frame = 0;  ///< Index into the job's frames.
    uint32_t tile = 0;
    friend bool operator==(const Tile&, const Tile&) = default;
  };
  std::vector<Tile> tiles;

  bool WasAt(JobKey job, int frame, uint32_t tile) const {
    return std::find(tiles.begin(), tiles.end(), Tile{job, frame, tile}) != tiles.end();
  }
};

struct SchedulerOptions {
  absl::Duration lease_ttl = absl::Seconds(15);
  absl::Duration stream_grace = absl::Seconds(1);
  absl::Duration batch_time = absl::Milliseconds(250);  ///< Of one thread: what a lease aims at.
  int max_batch_tiles = 1024;
  int max_tile_failures = 3;    ///< Reported, of one tile.
  int max_tile_deaths = 3;      ///< Different workers that ended while they rendered one tile.
  int max_deaths_at_all = 10;   ///< The same, of workers that come back under their old names, too.
  int max_worker_failures = 3;  ///< Tiles of one job that a worker may fail.
  /// A worker that asked for work this recently would take what another has failed.
  absl::Duration second_opinion = absl::Seconds(60);
  /// By how much a job may be ahead of another, times the farm's slots, before workers change over.
  absl::Duration share_slack = absl::Seconds(1);
  absl::Duration speculate_after = absl::Milliseconds(500);  ///< At least: see Speculate.
};

/// Which worker renders which tile: pure logic, no threads, no network, time from a Clock. Not thread-safe:
/// the farm's mutex guards it. docs/scheduling.md tells the policy as a whole.
///
/// A lease lives: Grant | Adopt | Speculate, Renew*, then Complete or Fail of all its tiles | Return | Expire
/// (TTL, or the grace after its worker was lost) | EndLeases | RemoveJob | RemoveWorker. Whatever of it is
/// not done is queued again, unless another lease holds it too.
///
/// Results count whoever sends them and whenever: a lease is an advice to the worker, not a condition.
class TileScheduler {
 public:
  TileScheduler(const Clock& clock, const SchedulerOptions& options) : clock_(clock), options_(options) {}

  // --- Jobs --------------------------------------------------------------------------------------------
  void AddJob(JobKey job, int frames, int columns, int rows, int priority = 0, const std::string& user = "",
              TileOrder order = TileOrder::kHilbert);
  /// Ends the job's leases; they are returned, their workers should hear of it.
  std::vector<EndedLease> RemoveJob(JobKey job);
  /// The job's tiles; null where the job is not scheduled. To mark what was done before a restart.
  JobQueue* Find(JobKey job);
  const JobQueue* Find(JobKey job) const;
  void SetPriority(JobKey job, int priority);
  /// Why a job gets nothing rendered, though it has tiles to render.
  enum class Block { kPaused = 1, kDependencies = 2, kAdoption = 4 };
  void SetBlocked(JobKey job, Block block, bool blocked);
  /// As RemoveJob, but the job stays.
  std::vector<EndedLease> EndLeases(JobKey job);

  // --- Workers -----------------------------------------------------------------------------------------
  /// Deaths of this very process (`boot_id`) that were counted turn out to be none.
  void AddWorker(WorkerId worker, const std::string& uuid, int slots, const std::string& boot_id = "",
                 const std::string& name = "");
  /// The worker left in order: its leases end at once and no tile is suspected.
  std::vector<EndedLease> RemoveWorker(WorkerId worker);
  /// The worker's process is known to be gone: what it rendered is suspected, which is what `end` says where
  /// that is known. Returns what is quarantined now.
  std::vector<Quarantined> BuryWorker(WorkerId worker, const WorkerEnd* end = nullptr);
  /// What is known by now of a process that has been buried: it goes to the evidence of tiles that are not
  /// done. Those that it was not at are acquitted, if it was at none, or one that it was at is held for it or
  /// done: somebody must answer for a death, or a tile that kills all workers would be tried for ever.
  void Testify(const std::string& worker_uuid, const WorkerEnd& end);
  /// The worker's stream broke: unless it is back within the grace, Expire buries it.
  void LoseWorker(WorkerId worker);
  void RegainWorker(WorkerId worker);
  /// A sign of life; `leases` are alive for another TTL, those that are this worker's.
  void Renew(WorkerId worker, const std::vector<LeaseId>& leases);

  // --- Leases ------------------------------------------------------------------------------------------
  /// The next lease for the worker; none if nothing is queued that it may have, or the worker is lost or
  /// silent for a TTL.
  std::optional<Lease> Grant(WorkerId worker);
  /// A lease of those of `tiles` that are queued, for a worker that was at them already when its leases ended
  /// or a new epoch began. None where there are no such tiles.
  std::optional<Lease> Adopt(WorkerId worker, JobKey job, int frame, const std::vector<uint32_t>& tiles);
  /// Copies, one for each of `idle` at most, of leases that have brought nothing for longer than twice the
  /// time that 95 of 100 of their job's tiles take, and speculate_after, and by `gather` more: so long
  /// results may wait at their worker. At most two leases hold a tile. For when nothing is queued
  /// (speculation.cpp).
  std::vector<Lease> Speculate(const std::vector<WorkerId>& idle,
                               absl::Duration gather = absl::ZeroDuration());
  /// How many of them were this worker's.
  int64_t Return(WorkerId worker, const std::vector<LeaseId>& leases);

  // --- Results -----------------------------------------------------------------------------------------
  /// A tile is rendered and stored. False if it was done before or is quarantined, or its job is not
  /// scheduled.
  bool Complete(JobKey job, int frame, uint32_t tile, WorkerId worker, absl::Duration render_time);
  /// A tile that the worker holds could not be rendered: it is queued again, or, after max_tile_failures,
  /// quarantined.
  std::optional<Quarantined> Fail(JobKey job, int frame, uint32_t tile, WorkerId worker,
                                  const std::string& reason);
  /// Leases that are over because others rendered their tiles, since the last call: workers should hear of
  /// it.
  std::vector<EndedLease> TakeRevoked() { return std::exchange(revoked_, {}); }
  /// Tiles that others than their leases' workers have delivered since the last call, of leases that are not
  /// over: workers should hear of those, too.
  std::vector<DroppedTile> TakeDropped();

  struct Expired {
    std::vector<EndedLease> leases;
    std::vector<WorkerId> workers;  ///< Lost and not back in time: removed.
    std::vector<Quarantined> quarantined;
  };
  /// Ends what has run out by now.
  Expired Expire();

  int64_t LeasedTiles(WorkerId worker) const;
  /// Recent mean time of a tile of this worker, zero before the first.
  absl::Duration TileTime(WorkerId worker) const;
  /// Of jobs that nothing blocks.
  int64_t QueuedTiles() const;
  /// What is left of the jobs that neither are paused nor wait for others.
  struct Demand {
    int64_t queued = 0, remaining = 0;  ///< Tiles; remaining: queued and leased.
    int64_t unmeasured = 0;             ///< Of the remaining ones: of jobs of which no tile has come back.
    double seconds = 0;                 ///< Thread time of the others, at their jobs' recent times a tile.
  };
  Demand Remaining() const;
  const FairShare& shares() const { return shares_; }

 private:
  struct Worker {
    std::string uuid, boot_id, name;
    int slots = 1;
    absl::Duration last_heard;
    absl::Duration last_asked = -absl::InfiniteDuration();  ///< For a lease.
    std::optional<absl::Duration> lost_until;               ///< Set: its stream is broken.
    std::map<LeaseId, Lease> leases;  ///< Oldest first: the first `slots` are being rendered.
    absl::Duration first_deadline = absl::InfiniteDuration();  ///< No lease ends before it.
    std::map<JobKey, std::deque<int>> held;                    ///< Frames it has set up, latest first.
    JobKey latest_job = 0;                                     ///< Of its latest lease.
    JobKey timed_job = 0;
    double tile_seconds = 0;  ///< Exponential mean over timed_job's tiles; 0: none yet.
  };
  struct Job {
    std::unique_ptr<JobQueue> queue;
    unsigned blocks = 0;      ///< Of Block.
    double tile_seconds = 0;  ///< Over all workers; 0: none yet.
    TileTimes times;
    /// Tiles that workers (UUIDs) have failed.
    std::map<std::string, std::set<std::pair<int, uint32_t>>> failed_by;
  };

  /// The worker, unless it is lost or silent.
  Worker* Ready(WorkerId worker);
  int BatchSize(const Worker& worker, JobKey key, const Job& job) const;
  std::optional<Lease> GrantFrom(WorkerId id, Worker& worker, JobKey key, Job& job);
  Lease NewLease(WorkerId id, JobKey job, int frame) const;
  /// Enters a lease that has got its tiles.
  const Lease& Enter(Worker& worker, Job& job, Lease lease);
  void EndLease(Worker& worker, const Lease& lease);
  std::vector<EndedLease> EndAll(Worker& worker);
  /// The holder holds the tile no longer; its lease ends with its last tile. `seconds`: what the tile took.
  void Settle(JobKey job, int frame, uint32_t tile, LeaseId holder, double seconds);

  // tile_troubles.cpp
  void Blame(const Worker& worker, const std::string& reason, const WorkerEnd* end,
             std::vector<Quarantined>& quarantined);
  void BlameTile(const Worker& worker, const Lease& lease, uint32_t tile, const std::string& reason,
                 const WorkerEnd* end, std::vector<Quarantined>& quarantined);
  std::optional<Quarantined> QuarantineIfHopeless(JobKey key, JobQueue& queue, int frame, uint32_t tile);
  /// Whether a worker has failed so much of a job that it gets no more of it, as long as others would.
  bool IsBarred(const Worker& worker, const Job& job) const;
  bool HasFailedEnough(const std::string& uuid, const Job& job) const;
  /// Whether somebody else asks for work who may have the job, and the tile with those troubles if given.
  bool AnotherWould(const Worker& worker, const Job& job, const TroubleLog* log) const;

  const Clock& clock_;
  const SchedulerOptions options_;
  std::map<JobKey, Job> jobs_;
  std::map<WorkerId, Worker> workers_;
  FairShare shares_;
  absl::flat_hash_map<LeaseId, WorkerId> lease_owner_;
  std::vector<EndedLease> revoked_;
  std::vector<DroppedTile> dropped_;
  int64_t slots_ = 0;  ///< Of all workers that are not lost.
  LeaseId next_lease_ = 1;
};

}  // namespace shutterline::server
