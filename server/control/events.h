#pragma once

#include <absl/status/status.h>
#include <absl/strings/string_view.h>
#include <absl/time/time.h>

#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <variant>
#include <vector>

#include "common/job/job_spec.h"
#include "common/job/render_stats.h"
#include "server/jobs/job_store.h"
#include "server/schedule/lease.h"

/// What the farm and the services say to each other, free of generated code.
namespace shutterline::server {

// --- To a worker's session ---------------------------------------------------------------------------

struct JobAnnounced {
  std::string job_id;
  std::shared_ptr<const JobSpec> spec;
};
struct LeaseGranted {
  LeaseId lease = 0;
  std::string job_id;
  int frame = 0;  ///< The frame's number.
  std::vector<uint32_t> tiles;
  bool send_at_once = false;
  LeaseId adopts = 0;  ///< Not 0: what the worker calls the lease that this one continues.
};
struct LeasesRevoked {
  std::vector<LeaseId> leases;
  std::map<LeaseId, std::vector<uint32_t>> tiles;  ///< Of leases that go on without them.
};
struct JobForgotten {
  std::string job_id;
};
struct DrainAsked {};
struct AllAdopted {};  ///< Of what the worker said it holds.
using WorkerEvent =
    std::variant<JobAnnounced, LeaseGranted, LeasesRevoked, JobForgotten, DrainAsked, AllAdopted>;

/// The stream to a worker. Called under the farm's mutex: must return at once and not call back.
class WorkerSink {
 public:
  virtual ~WorkerSink() = default;
  virtual void Send(WorkerEvent event) = 0;
  /// Ends the stream, after what was sent. Nothing is sent afterwards.
  virtual void Close(const absl::Status& status) = 0;
};

// --- From a worker -----------------------------------------------------------------------------------

/// What a worker is at since an earlier session.
struct HeldLease {
  LeaseId ticket = 0;  ///< The worker's own number of it; not 0.
  std::string job_id;
  int frame = 0;  ///< The frame's number.
  std::vector<uint32_t> tiles;
};

struct TileReport {
  std::string job_id;
  int frame = 0;  ///< The frame's number.
  uint32_t tile = 0;
  bool failed = false;
  std::string pixels;   ///< Unless it failed: little-endian floats.
  std::string failure;  ///< Where it failed: why.
  absl::Duration render_time;
  RenderStats stats;        ///< Zeros where the worker measured nothing.
  absl::Duration received;  ///< When it arrived, by the monotonic clock; ResultCommitter sets it.
};

enum class ReportOutcome { kStored, kDuplicate, kMismatch, kUnwanted, kRefused };

// --- To clients --------------------------------------------------------------------------------------

enum class FrameState { kQueued, kRunning, kFinished };

struct FrameSnapshot {
  int frame = 0;  ///< The frame's number.
  FrameState state = FrameState::kQueued;
  int tiles_total = 0, tiles_done = 0;
  Digest digest;          ///< Where finished.
  uint64_t size = 0;      ///< Where finished: bytes.
  RenderStats stats;      ///< Of the tiles that came since the coordinator's start, or of the finished frame.
  int tiles_missing = 0;  ///< Quarantined.
};

struct JobSnapshot {
  uint64_t key = 0;
  std::string id;
  std::shared_ptr<const JobSpec> spec;
  JobState state = JobState::kQueued;
  std::string error;
  int64_t frames_total = 0, frames_finished = 0;
  int64_t tiles_total = 0, tiles_done = 0;
  int64_t mismatched_tiles = 0;
  absl::Time submitted, ended;
  int workers = 0;
  bool paused = false;
  JobWishes wishes;
  std::set<std::string> waits_for;  ///< Those of wishes.after that have not succeeded.
  int64_t tiles_quarantined = 0;
};

struct JobChange {
  uint64_t seq = 0;
  std::variant<JobSnapshot, FrameSnapshot> what;
};

struct WorkerSnapshot {
  std::string uuid, name, build_id, isa;
  int64_t slots = 0;
  bool draining = false;
  int64_t leased_tiles = 0, tiles_done = 0;
  absl::Duration tile_time, silent;
};

/// The farm as a whole, at a moment.
struct FarmTotals {
  int64_t workers = 0, slots = 0, draining_workers = 0;
  std::map<JobState, int64_t> jobs;  ///< Those that have not ended.
  int64_t queued_tiles = 0, leased_tiles = 0;
  int64_t remaining_tiles = 0;   ///< Queued and leased, of all jobs.
  double remaining_seconds = 0;  ///< Thread time of those of them whose job has been measured.
  int64_t unmeasured_tiles = 0;  ///< Of them, tiles of jobs none of whose tiles has come back.
};

/// Hears that a job has changed. Called under the farm's mutex: must return at once and not call back.
class JobWatcher {
 public:
  virtual ~JobWatcher() = default;
  virtual void OnChange() = 0;
};

}  // namespace shutterline::server
