#pragma once

#include <absl/base/thread_annotations.h>
#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>
#include <absl/synchronization/mutex.h>

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "common/base/clock.h"
#include "common/cryptomatte/cryptomatte.h"
#include "server/assemble/tile_journal.h"
#include "server/assets/asset_store.h"
#include "server/config/config.h"
#include "server/control/events.h"
#include "server/control/live_job.h"
#include "server/control/work_pool.h"
#include "server/jobs/job_store.h"
#include "server/schedule/tile_scheduler.h"
#include "server/schedule/worker_registry.h"

namespace shutterline::server {

/// Jobs, workers and what passes between them: the one place where stores, journal and scheduler meet.
///
/// Thread-safe. One mutex guards jobs, scheduler and registry; nothing waits for a disk under it. What is
/// told to clients as done (a job accepted or ended, a frame finished) is on disk before.
class Farm {
 public:
  struct Parts {
    Config config;
    const Clock* clock = nullptr;
    JobStore* store = nullptr;
    AssetStore* assets = nullptr;
    TileJournal* journal = nullptr;
    WorkPool* frames_pool = nullptr;  ///< Writes finished frames.
    std::string frames_folder;
    uint64_t epoch = 0;
    CoordinatorIdentity identity;
    /// Whether a job's scene can be rendered; called without locks, may take long.
    std::function<absl::Status(const JobSpec&, AssetStore&)> check_scene;
    /// What the mattes of a job are named after; likewise.
    std::function<absl::StatusOr<MatteNames>(const JobSpec&, AssetStore&)> matte_names;
    /// Where the camera of a job's frame is; likewise.
    std::function<absl::StatusOr<CameraMatrices>(const JobSpec&, AssetStore&, int frame)> camera;
  };
  explicit Farm(Parts parts);
  ~Farm();

  /// Takes up the jobs that had not ended when the last coordinator did. To be called once, at first.
  absl::Status Resume();

  // --- Clients (farm_clients.cpp). Submit, Cancel and the first call for an ended job use the disk. ----
  absl::StatusOr<JobSnapshot> Submit(const std::string& request_id, const JobSpec& spec);
  absl::StatusOr<JobSnapshot> Get(const std::string& job_id);
  /// Up to `limit` jobs with smaller keys than `before`, latest first.
  absl::StatusOr<std::vector<JobSnapshot>> List(uint64_t before, int limit);
  absl::StatusOr<JobSnapshot> Cancel(const std::string& job_id);
  /// The finished frame and its file.
  absl::StatusOr<std::pair<FrameSnapshot, std::string>> FindFrame(const std::string& job_id, int frame);
  std::vector<WorkerSnapshot> Workers();

  absl::Status AddWatcher(const std::string& job_id, JobWatcher* watcher);
  void RemoveWatcher(const std::string& job_id, JobWatcher* watcher);
  /// The first change of a watched job after `seq`; none: `ended` says whether there will be another.
  std::optional<JobChange> NextChange(const std::string& job_id, uint64_t seq, bool& ended);

  // --- Workers (farm_workers.cpp). None uses the disk. --------------------------------------------------
  uint64_t epoch() const { return parts_.epoch; }
  absl::StatusOr<WorkerEntry> Register(const WorkerHello& hello);
  /// Opens the session's stream; one that is open is closed. ABORTED where epoch or session are not current.
  absl::StatusOr<WorkerId> Attach(const std::string& session_id, uint64_t epoch, WorkerSink* sink);
  /// The stream has ended. `orderly`: the worker closed it, so what it holds can be leased again at once.
  void Detach(WorkerId worker, WorkerSink* sink, bool orderly);
  void AddCredit(WorkerId worker, int64_t leases);
  void Heartbeat(WorkerId worker, const std::vector<LeaseId>& leases);
  void ReturnLeases(WorkerId worker, const std::vector<LeaseId>& leases);
  void WorkerDrains(WorkerId worker);
  /// ABORTED as for Attach.
  absl::StatusOr<WorkerId> FindSession(const std::string& session_id, uint64_t epoch);
  /// Asks all workers to drain and grants nothing any more.
  void Drain();
  /// Ends all streams to workers.
  void CloseSessions(const absl::Status& status);

  // --- Results (farm_results.cpp), called by ResultCommitter. -------------------------------------------
  struct Destination {
    ReportOutcome refusal = ReportOutcome::kStored;  ///< kUnwanted or kRefused: not to be stored.
    TileAddress address;
  };
  /// Where reports belong.
  std::vector<Destination> Locate(const std::vector<const TileReport*>& reports);
  struct Result {
    const TileReport* report = nullptr;
    Destination destination;
    WorkerId worker = 0;
    TileJournal::Outcome stored = TileJournal::Outcome::kStaged;
  };
  /// Counts what is durable by now (and failures).
  void Apply(const std::vector<Result>& results);

  /// Ends what has run out and tells watchers what has changed; to be called some twenty times a second.
  void Tick();

 private:
  using JobPtr = std::shared_ptr<LiveJob>;

  uint64_t NextSeq() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  JobPtr FindLive(const std::string& job_id) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  /// The job, read from the store if it has ended and is not in memory.
  absl::StatusOr<JobPtr> Find(const std::string& job_id) ABSL_LOCKS_EXCLUDED(mutex_);
  absl::StatusOr<JobPtr> Load(const JobRecord& record) ABSL_LOCKS_EXCLUDED(mutex_);
  JobSnapshot Snapshot(const LiveJob& job) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  absl::Status CheckBlobs(const JobSpec& spec);
  absl::Status ResumeJob(const JobRecord& record);
  void ForgetOldJobs() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Notify(LiveJob& job) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  /// Ends a job: durable, then visible. Not under the mutex.
  absl::Status EndJob(const JobPtr& job, JobState state, const std::string& error)
      ABSL_LOCKS_EXCLUDED(mutex_);
  void EndPoisoned(const std::vector<PoisonedTile>& poisoned) ABSL_LOCKS_EXCLUDED(mutex_);

  std::string FramePath(const LiveJob& job, int index) const;
  void WriteFrameSoon(const JobPtr& job, int index);
  void WriteFrame(const JobPtr& job, int index) ABSL_LOCKS_EXCLUDED(mutex_);

  void Pump() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  bool GrantOne(WorkerEntry& worker) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Revoke(const std::vector<EndedLease>& ended) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void DropWorker(WorkerId worker, const absl::Status& status) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  struct Session {
    WorkerSink* sink = nullptr;
    std::set<std::string> announced;  ///< Jobs that the stream has described.
  };

  const Parts parts_;
  absl::Mutex end_mutex_ ABSL_ACQUIRED_BEFORE(mutex_);  ///< Serialises EndJob.
  absl::Mutex mutex_;
  TileScheduler scheduler_ ABSL_GUARDED_BY(mutex_);
  WorkerRegistry registry_ ABSL_GUARDED_BY(mutex_);
  std::map<std::string, JobPtr> jobs_ ABSL_GUARDED_BY(mutex_);
  std::map<JobKey, JobPtr> by_key_ ABSL_GUARDED_BY(mutex_);
  std::deque<std::string> ended_ ABSL_GUARDED_BY(mutex_);  ///< In memory, longest ended first.
  std::map<WorkerId, Session> sessions_ ABSL_GUARDED_BY(mutex_);
  std::set<WorkerId> wanting_ ABSL_GUARDED_BY(mutex_);  ///< Attached workers with credit.
  bool draining_ ABSL_GUARDED_BY(mutex_) = false;
  uint64_t last_seq_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace shutterline::server
