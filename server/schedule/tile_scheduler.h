#pragma once

#include <absl/container/flat_hash_map.h>
#include <absl/time/time.h>

#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/base/clock.h"
#include "server/schedule/job_queue.h"
#include "server/schedule/lease.h"

namespace shutterline::server {

struct SchedulerOptions {
  absl::Duration lease_ttl = absl::Seconds(15);
  absl::Duration stream_grace = absl::Seconds(1);
  absl::Duration batch_time = absl::Milliseconds(250);  ///< Of one thread: what a lease aims at.
  int max_batch_tiles = 1024;
  int max_tile_failures = 3;
  int max_tile_deaths = 5;  ///< Different workers that ended while they rendered one tile.
};

/// Which worker renders which tile: pure logic, no threads, no network, time from a Clock. Not thread-safe:
/// JobManager's mutex guards it.
///
/// A lease lives: Grant, Renew*, then Complete or Fail of all its tiles | Return | Expire (TTL, or the
/// grace after its worker was lost) | RemoveJob | RemoveWorker. Whatever of it is not done is queued again.
/// Jobs are served oldest first; within a job a worker stays with its frames (JobQueue::ChooseFrame).
///
/// Results count whoever sends them and whenever: a lease is an advice to the worker, not a condition.
class TileScheduler {
 public:
  TileScheduler(const Clock& clock, const SchedulerOptions& options) : clock_(clock), options_(options) {}

  void AddJob(JobKey job, int frames, int columns, int rows);
  /// Ends the job's leases; they are returned, their workers should hear of it.
  std::vector<EndedLease> RemoveJob(JobKey job);
  /// The job's tiles; null where the job is not scheduled. To mark what was done before a restart.
  JobQueue* Find(JobKey job);
  const JobQueue* Find(JobKey job) const;

  void AddWorker(WorkerId worker, const std::string& uuid, int slots);
  /// The worker left in order: its leases end at once and no tile is suspected.
  std::vector<EndedLease> RemoveWorker(WorkerId worker);
  /// The worker's stream broke: unless it is back within the grace, Expire ends its leases and removes it.
  void LoseWorker(WorkerId worker);
  void RegainWorker(WorkerId worker);

  /// A sign of life; `leases` are alive for another TTL, those that are this worker's.
  void Renew(WorkerId worker, const std::vector<LeaseId>& leases);
  /// The next lease for the worker; none if nothing is queued, or the worker is lost or silent for a TTL.
  std::optional<Lease> Grant(WorkerId worker);
  /// How many of them were this worker's.
  int64_t Return(WorkerId worker, const std::vector<LeaseId>& leases);

  /// A tile is rendered and stored. False if it was done before, or its job is not scheduled.
  bool Complete(JobKey job, int frame, uint32_t tile, WorkerId worker, absl::Duration render_time);
  /// A tile could not be rendered: it is queued again, or, after max_tile_failures, poisons its job.
  std::optional<PoisonedTile> Fail(JobKey job, int frame, uint32_t tile, WorkerId worker,
                                   const std::string& reason);

  struct Expired {
    std::vector<EndedLease> leases;
    std::vector<WorkerId> workers;  ///< Lost and not back in time: removed.
    std::vector<PoisonedTile> poisoned;
  };
  /// Ends what has run out by now.
  Expired Expire();

  int64_t LeasedTiles(WorkerId worker) const;
  /// Recent mean time of a tile of this worker, zero before the first.
  absl::Duration TileTime(WorkerId worker) const;
  int64_t QueuedTiles() const;
  /// What is left of all jobs.
  struct Demand {
    int64_t queued = 0, remaining = 0;  ///< Tiles; remaining: queued and leased.
    int64_t unmeasured = 0;             ///< Of the remaining ones: of jobs of which no tile has come back.
    double seconds = 0;                 ///< Thread time of the others, at their jobs' recent times a tile.
  };
  Demand Remaining() const;

 private:
  struct Worker {
    std::string uuid;
    int slots = 1;
    absl::Duration last_heard;
    std::optional<absl::Duration> lost_until;  ///< Set: its stream is broken.
    std::map<LeaseId, Lease> leases;           ///< Oldest first: the first `slots` are being rendered.
    std::map<JobKey, std::deque<int>> held;    ///< Frames it has set up, latest first.
    JobKey timed_job = 0;
    double tile_seconds = 0;  ///< Exponential mean over timed_job's tiles; 0: none yet.
  };
  struct Job {
    std::unique_ptr<JobQueue> queue;
    double tile_seconds = 0;  ///< Over all workers; 0: none yet.
  };

  int BatchSize(const Worker& worker, JobKey key, const Job& job) const;
  void EndLease(Worker& worker, const Lease& lease);
  std::vector<EndedLease> EndAll(Worker& worker);
  void Blame(const Worker& worker, std::vector<PoisonedTile>& poisoned);
  void Settle(JobKey job, int frame, uint32_t tile, LeaseId holder);

  const Clock& clock_;
  const SchedulerOptions options_;
  std::map<JobKey, Job> jobs_;
  std::map<WorkerId, Worker> workers_;
  absl::flat_hash_map<LeaseId, WorkerId> lease_owner_;
  int64_t slots_ = 0;  ///< Of all workers that are not lost.
  LeaseId next_lease_ = 1;
};

}  // namespace shutterline::server
