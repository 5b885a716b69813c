#pragma once

#include <absl/base/thread_annotations.h>
#include <absl/container/flat_hash_set.h>
#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>
#include <absl/synchronization/mutex.h>

#include <atomic>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "common/base/clock.h"
#include "common/cryptomatte/cryptomatte.h"
#include "common/image/exr.h"
#include "server/assemble/frame_blocks.h"
#include "server/assemble/tile_journal.h"
#include "server/assets/asset_store.h"
#include "server/config/config.h"
#include "server/control/events.h"
#include "server/control/later_tasks.h"
#include "server/control/live_job.h"
#include "server/control/observer.h"
#include "server/control/work_pool.h"
#include "server/jobs/job_store.h"
#include "server/schedule/gather_pace.h"
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
    FrameBlocks* blocks = nullptr;    ///< What is compressed as tiles come.
    WorkPool* frames_pool = nullptr;  ///< Writes finished frames.
    std::string frames_folder;
    uint64_t epoch = 0;
    CoordinatorIdentity identity;
    FarmObserver* observer = nullptr;  ///< Hears what happens; may be null.
    /// Whether a job's scene can be rendered; called without locks, may take long.
    std::function<absl::Status(const JobSpec&, AssetStore&)> check_scene;
    /// What the mattes of a job are named after; likewise.
    std::function<absl::StatusOr<MatteNames>(const JobSpec&, AssetStore&)> matte_names;
    /// Where the camera of a job's frame is; likewise.
    std::function<absl::StatusOr<CameraMatrices>(const JobSpec&, AssetStore&, int frame)> camera;
    /// Removes what is logged of a job, without locks; null: nothing is.
    std::function<absl::Status(const std::string& job_id)> remove_log;
  };
  explicit Farm(Parts parts);
  ~Farm();

  /// Takes up the jobs that had not ended when the last coordinator did. To be called once, at first.
  absl::Status Resume();

  // --- Clients (farm_clients.cpp). Submit and the first call for an ended job use the disk. ------------
  absl::StatusOr<JobSnapshot> Submit(const std::string& request_id, const JobSpec& spec,
                                     const JobWishes& wishes);
  absl::StatusOr<JobSnapshot> Get(const std::string& job_id);
  /// Up to `limit` jobs with smaller keys than `before`, latest first.
  absl::StatusOr<std::vector<JobSnapshot>> List(uint64_t before, int limit);
  /// The job's quarantined tiles, by frame and tile: up to `limit`.
  absl::StatusOr<std::vector<QuarantinedTile>> QuarantinedTiles(const std::string& job_id, size_t limit);
  /// The finished frame and its file.
  absl::StatusOr<std::pair<FrameSnapshot, std::string>> FindFrame(const std::string& job_id, int frame);
  std::vector<WorkerSnapshot> Workers();
  FarmTotals Totals();
  /// Up to `limit` jobs in memory that changed after `seq`, longest unchanged first, each with the number of
  /// its change; frames apart. Numbers grow over restarts.
  std::vector<std::pair<uint64_t, JobSnapshot>> ChangedJobs(uint64_t seq, size_t limit);
  /// The number of the latest change.
  uint64_t LastSeq();
  struct FrameView {
    std::shared_ptr<const JobSpec> spec;
    FrameSnapshot frame;
    TileJournal::FrameKey key;  ///< Where the journal keeps its tiles, unless it is finished.
    std::string path;           ///< Of the EXR, once it is finished.
  };
  absl::StatusOr<FrameView> ViewFrame(const std::string& job_id, int frame);
  /// Up to `limit` frames from index `first` on.
  absl::StatusOr<std::vector<FrameSnapshot>> Frames(const std::string& job_id, int64_t first, int64_t limit);

  absl::Status AddWatcher(const std::string& job_id, JobWatcher* watcher);
  void RemoveWatcher(const std::string& job_id, JobWatcher* watcher);
  /// The first change of a watched job after `seq`; none: `ended` says whether there will be another.
  std::optional<JobChange> NextChange(const std::string& job_id, uint64_t seq, bool& ended);

  FarmObserver& observer() { return observer_; }
  const Clock& clock() const { return *parts_.clock; }

  // --- Control (farm_control.cpp). All use the disk. Each is OK where there is nothing to change. --------
  absl::StatusOr<JobSnapshot> Cancel(const std::string& job_id);
  absl::StatusOr<JobSnapshot> SetPaused(const std::string& job_id, bool paused);
  absl::StatusOr<JobSnapshot> SetPriority(const std::string& job_id, int priority);
  /// Tries again what is missing of a job that has not succeeded.
  absl::StatusOr<JobSnapshot> Retry(const std::string& job_id);
  /// Forgets a job that has ended and that nobody waits for, and returns what it was (farm_removal.cpp). Its
  /// files follow soon, after a crash too.
  absl::StatusOr<JobSnapshot> Remove(const std::string& job_id);

  // --- Workers (farm_workers.cpp). None uses the disk. --------------------------------------------------
  uint64_t epoch() const { return parts_.epoch; }
  absl::StatusOr<WorkerEntry> Register(const WorkerHello& hello);
  /// Opens the session's stream; one that is open is closed. Of `held`, what the worker is at since an
  /// earlier session, it is granted again what nobody else has got. ABORTED where epoch or session are not
  /// current.
  absl::StatusOr<WorkerId> Attach(const std::string& session_id, uint64_t epoch,
                                  const std::vector<HeldLease>& held, WorkerSink* sink);
  /// The stream has ended. `orderly`: the worker closed it, so what it holds can be leased again at once.
  void Detach(WorkerId worker, WorkerSink* sink, bool orderly);
  void AddCredit(WorkerId worker, int64_t leases);
  void Heartbeat(WorkerId worker, const std::vector<LeaseId>& leases);
  void ReturnLeases(WorkerId worker, const std::vector<LeaseId>& leases);
  void WorkerDrains(WorkerId worker);
  /// How long workers are to gather results before they send them. Takes no lock.
  absl::Duration gather() const { return absl::Nanoseconds(gather_ns_.load(std::memory_order_relaxed)); }
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
    TileReport* report = nullptr;
    Destination destination;
    WorkerId worker = 0;
    TileJournal::Outcome stored = TileJournal::Outcome::kStaged;
    Digest digest;  ///< Of the pixels, where there are any to be stored.
  };
  /// Counts what is durable by now (and failures). Takes the pixels of what was stored.
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
  std::shared_ptr<const BlobPins> PinBlobs(const JobSpec& spec);
  absl::Status CheckNotRemoved(const std::string& request_id);
  absl::Status CheckWishes(const JobWishes& wishes) ABSL_LOCKS_EXCLUDED(mutex_);

  /// What the disk knows of a job that is to be taken up (farm_resume.cpp).
  struct StoredProgress {
    std::vector<FinishedFrame> finished;  ///< Whose files are there.
    std::vector<QuarantinedTile> quarantined;
    std::vector<std::string> waits_for;
    std::shared_ptr<const BlobPins> blobs;
  };
  absl::StatusOr<StoredProgress> ReadProgress(const JobRecord& record);
  /// Enters a job that has not ended; returns it and the frames that can be written.
  std::pair<JobPtr, std::vector<int>> TakeUp(const JobRecord& record, const StoredProgress& progress)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  /// Both of these, then writes what can be written.
  absl::Status ResumeJob(const JobRecord& record) ABSL_EXCLUSIVE_LOCKS_REQUIRED(control_mutex_);
  void ForgetOldJobs() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  /// NOT_FOUND, with what is remembered of the job.
  absl::Status NoSuchJob(const std::string& job_id);
  /// How a job stands, or had ended before it was removed.
  absl::StatusOr<JobState> StoredState(const std::string& job_id);

  // farm_removal.cpp
  /// A job that has not ended and waits for this one; empty: none.
  std::string WhoWaitsFor(const std::string& job_id) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  absl::Status RemoveLocked(JobKey key, const std::string& job_id)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(control_mutex_) ABSL_LOCKS_EXCLUDED(mutex_);
  /// Removes what has been kept for long enough, and looks again after a while.
  void RemoveOldJobs() ABSL_LOCKS_EXCLUDED(control_mutex_, mutex_);
  absl::Status RemoveDueJobs() ABSL_LOCKS_EXCLUDED(control_mutex_, mutex_);
  /// The files of a job that is removed; `failures`: how often it has been tried in vain.
  void RemoveFilesSoon(JobKey key, const std::string& job_id, int failures);
  void RemoveFiles(JobKey key, const std::string& job_id, int failures) ABSL_LOCKS_EXCLUDED(mutex_);
  void Notify(LiveJob& job) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  /// Ends a job: durable, then visible. Not under the mutex.
  absl::Status EndJob(const JobPtr& job, JobState state, const std::string& error)
      ABSL_LOCKS_EXCLUDED(control_mutex_, mutex_);
  absl::Status EndJobLocked(const JobPtr& job, JobState state, const std::string& error)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(control_mutex_) ABSL_LOCKS_EXCLUDED(mutex_);
  /// Ends a job all of whose frames are finished.
  absl::Status EndFinishedJob(const JobPtr& job) ABSL_EXCLUSIVE_LOCKS_REQUIRED(control_mutex_);
  /// Hands a job to the scheduler.
  void Schedule(LiveJob& job, const std::vector<std::string>& waits_for)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  /// Jobs that waited for this one alone may begin.
  void StartDependents(const std::string& job_id) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  /// What the scheduler has quarantined: durable, then visible (farm_quarantine.cpp). Not under the mutex.
  void Quarantine(const std::vector<Quarantined>& tiles) ABSL_LOCKS_EXCLUDED(control_mutex_, mutex_);
  void QuarantineOne(const Quarantined& tile) ABSL_LOCKS_EXCLUDED(control_mutex_, mutex_);

  std::string FramePath(const std::string& job_id, int frame) const;  ///< The frame's number.
  std::string FramePath(const LiveJob& job, int index) const;
  /// `failures`: how often it has been tried in vain. A frame for which the disk has no room, for now, is
  /// tried again later; its tiles stay in the journal meanwhile.
  void WriteFrameSoon(const JobPtr& job, int index, int failures = 0);
  void WriteFrame(const JobPtr& job, int index, int failures) ABSL_LOCKS_EXCLUDED(mutex_);

  void Pump() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  bool GrantOne(WorkerEntry& worker) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void SendLease(WorkerEntry& worker, const Lease& lease, LeaseId adopts)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  /// Has stragglers rendered twice by workers with credit, if nothing is queued.
  void Speculate() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // farm_adoption.cpp
  void Adopt(WorkerEntry& worker, const std::vector<HeldLease>& held) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  /// Jobs that were taken up wait for workers that were connected when the last coordinator ended.
  absl::Status AwaitWorkers() ABSL_LOCKS_EXCLUDED(mutex_);
  void EndAdoption() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void NoteWorker(const std::string& uuid) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // farm_evidence.cpp
  /// How a process of a worker ended, in the scheduler's terms.
  WorkerEnd EndOf(const WorkerExit& exit) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  /// Adds what a supervisor has seen to what is known of a worker's death.
  void Testify(const WorkerHello& hello, const WorkerExit& exit) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void LogExit(const WorkerHello& hello, const WorkerEnd& end) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void StoreEvidence(const JobPtr& job, int index, uint32_t tile) ABSL_LOCKS_EXCLUDED(control_mutex_, mutex_);
  void Revoke(const std::vector<EndedLease>& ended, const std::vector<DroppedTile>& dropped = {})
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  /// The worker's UUID for a log, "gone" where it is not registered any more.
  std::string WorkerName(WorkerId worker) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void DropWorker(WorkerId worker, const absl::Status& status) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  struct Session {
    WorkerSink* sink = nullptr;
    std::set<std::string> announced;  ///< Jobs that the stream has described.
  };

  const Parts parts_;
  FarmObserver& observer_;  ///< Somebody who hears nothing, where nobody else was given.
  LaterTasks later_;        ///< What the disk refused; Tick tries it again.
  absl::Mutex control_mutex_ ABSL_ACQUIRED_BEFORE(mutex_);  ///< Held while a job's stored state changes.
  absl::Mutex mutex_;
  TileScheduler scheduler_ ABSL_GUARDED_BY(mutex_);
  WorkerRegistry registry_ ABSL_GUARDED_BY(mutex_);
  std::map<std::string, JobPtr> jobs_ ABSL_GUARDED_BY(mutex_);
  std::map<JobKey, JobPtr> by_key_ ABSL_GUARDED_BY(mutex_);
  std::deque<std::string> ended_ ABSL_GUARDED_BY(mutex_);  ///< In memory, longest ended first.
  /// Removed since the start: what was read of them before must not come back into memory.
  absl::flat_hash_set<JobKey> removed_ ABSL_GUARDED_BY(mutex_);
  std::map<JobKey, int> writing_ ABSL_GUARDED_BY(mutex_);  ///< Frames of a job that are being written.
  std::map<WorkerId, Session> sessions_ ABSL_GUARDED_BY(mutex_);
  std::set<WorkerId> wanting_ ABSL_GUARDED_BY(mutex_);     ///< Attached workers with credit.
  std::set<std::string> awaited_ ABSL_GUARDED_BY(mutex_);  ///< Workers that may come back with leases.
  absl::Duration await_until_ ABSL_GUARDED_BY(mutex_);
  absl::Duration next_roll_call_ ABSL_GUARDED_BY(mutex_);
  /// Workers that came (true) or went, not stored yet.
  std::map<std::string, bool> worker_notes_ ABSL_GUARDED_BY(mutex_);
  std::vector<Quarantined> buried_
      ABSL_GUARDED_BY(mutex_);  ///< What was quarantined when workers started anew.
  /// Processes of workers (UUID, boot id) whose end is in the log, the latest last.
  std::deque<std::pair<std::string, std::string>> logged_exits_ ABSL_GUARDED_BY(mutex_);
  std::vector<Quarantined> unstored_ ABSL_GUARDED_BY(mutex_);  ///< Quarantined, but the disk refused.
  GatherPace gather_pace_ ABSL_GUARDED_BY(mutex_){{}};
  std::atomic<int64_t> gather_ns_;  ///< What gather_pace_ says.
  bool draining_ ABSL_GUARDED_BY(mutex_) = false;
  uint64_t last_seq_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace shutterline::server
