#pragma once

#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>
#include <absl/time/time.h>

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "common/asset/digest.h"
#include "common/job/job_spec.h"
#include "common/job/render_stats.h"
#include "server/schedule/tile_trouble.h"

namespace shutterline::server {

/// Numbers are stored: never change one.
enum class JobState { kQueued = 1, kRunning = 2, kSucceeded = 3, kFailed = 4, kCancelled = 5, kPartial = 6 };

inline bool HasEnded(JobState state) {
  return state != JobState::kQueued && state != JobState::kRunning;
}

inline constexpr int kMaxPriority = 1000;
inline constexpr size_t kMaxUserBytes = 128;
inline constexpr size_t kMaxAfter = 64;

/// What a job asks of the farm beside its pictures.
struct JobWishes {
  int priority = 0;  ///< -kMaxPriority to kMaxPriority: higher is served first.
  std::string user;  ///< On whose account; at most kMaxUserBytes.
  /// Ids of jobs that must succeed first, each once; at most kMaxAfter.
  std::vector<std::string> after;
};

/// A job as it is on disk. That it is running is not stored: a job that has not ended is queued.
struct JobRecord {
  uint64_t key = 0;  ///< Grows with every job.
  std::string id;    ///< A UUID.
  std::string request_id;
  JobSpec spec;
  JobWishes wishes;
  bool paused = false;
  JobState state = JobState::kQueued;
  std::string error;
  absl::Time submitted;
  absl::Time ended = absl::InfinitePast();  ///< InfinitePast: it has not.
};

/// A job that has ended, by when.
struct EndedJob {
  uint64_t key = 0;
  std::string id;
  absl::Time ended = absl::InfinitePast();
};

/// What is remembered of a job that was removed.
struct RemovedJob {
  uint64_t key = 0;
  std::string id;
  JobState state = JobState::kQueued;  ///< How it had ended.
  absl::Time removed;
};

/// The EXR of a finished frame.
struct FinishedFrame {
  int frame = 0;  ///< The frame's number.
  Digest digest;
  uint64_t size = 0;  ///< Bytes.
  RenderStats stats;  ///< What its tiles took; zeros where that is not known.
  int missing = 0;    ///< Tiles that the file lacks: they were quarantined.
};

/// A tile that is not tried any more, and why.
struct QuarantinedTile {
  int frame = 0;  ///< The frame's number.
  uint32_t tile = 0;
  std::vector<TileTrouble> evidence;  ///< Oldest first.
};

/// Durable state of jobs. Whatever a call has acknowledged survives a crash of the process and of the
/// machine. Thread-safe. Errors: NOT_FOUND, UNAVAILABLE or RESOURCE_EXHAUSTED (the disk), DATA_LOSS.
class JobStore {
 public:
  virtual ~JobStore() = default;

  /// Counts the starts of the coordinator: one more than what it last returned, 1 at first.
  virtual absl::StatusOr<uint64_t> NextEpoch() = 0;

  struct Created {
    JobRecord job;
    bool is_new = false;
  };
  /// Stores a job, or returns the one that has this request id, which the caller is to compare.
  virtual absl::StatusOr<Created> Create(const std::string& request_id, const JobSpec& spec,
                                         const JobWishes& wishes, absl::Time now) = 0;
  virtual absl::StatusOr<JobRecord> Get(absl::string_view id) = 0;
  /// NOT_FOUND where the request id has not been used.
  virtual absl::StatusOr<JobRecord> FindRequest(absl::string_view request_id) = 0;
  /// Up to `limit` jobs with smaller keys than `before`, latest first.
  virtual absl::StatusOr<std::vector<JobRecord>> List(uint64_t before, int limit) = 0;
  /// All jobs that have not ended, oldest first.
  virtual absl::StatusOr<std::vector<JobRecord>> Unfinished() = 0;

  /// Ends the job. A job that has ended stays as it is.
  virtual absl::Status End(uint64_t key, JobState state, const std::string& error, absl::Time now) = 0;

  virtual absl::Status SetPaused(uint64_t key, bool paused) = 0;
  virtual absl::Status SetPriority(uint64_t key, int priority) = 0;
  /// The job is to be tried again: it is unfinished, none of its tiles is quarantined, and frames that lacked
  /// tiles are not finished.
  virtual absl::Status Retry(uint64_t key) = 0;

  /// Up to `limit` jobs that have ended, longest ended first, from the one behind `after` on; by default all.
  virtual absl::StatusOr<std::vector<EndedJob>> Ended(const EndedJob& after, int limit) = 0;
  virtual absl::StatusOr<int64_t> CountEnded() = 0;
  /// Removes a job that has ended, with all that is stored of it, and remembers that it is to be followed by
  /// its files (HalfRemoved). NOT_FOUND where it is not there or has not ended.
  virtual absl::Status Remove(uint64_t key, absl::Time now) = 0;
  /// The files of a removed job are gone.
  virtual absl::Status FilesRemoved(const std::string& id) = 0;
  /// Jobs that were removed and whose files may still be there.
  virtual absl::StatusOr<std::vector<RemovedJob>> HalfRemoved() = 0;
  /// What is remembered of it. NOT_FOUND where no such job was removed.
  virtual absl::StatusOr<RemovedJob> FindRemoved(absl::string_view id) = 0;
  /// The same of the job that had this request id.
  virtual absl::StatusOr<RemovedJob> FindRemovedRequest(absl::string_view request_id) = 0;

  /// Notes workers (UUIDs) that are connected from now on (true), or not any more.
  virtual absl::Status NoteWorkers(const std::map<std::string, bool>& connected) = 0;
  virtual absl::StatusOr<std::vector<std::string>> ConnectedWorkers() = 0;

  /// Quarantines a tile; what was known of it before is replaced.
  virtual absl::Status Quarantine(uint64_t key, const QuarantinedTile& tile) = 0;
  /// By frame and tile.
  virtual absl::StatusOr<std::vector<QuarantinedTile>> QuarantinedTiles(uint64_t key) = 0;
  /// Frames with quarantined tiles, of all jobs: job and frame number.
  virtual absl::StatusOr<std::vector<std::pair<uint64_t, int>>> QuarantinedFrames() = 0;

  virtual absl::Status AddFinishedFrame(uint64_t key, const FinishedFrame& frame) = 0;
  virtual absl::Status RemoveFinishedFrame(uint64_t key, int frame) = 0;
  /// By frame number.
  virtual absl::StatusOr<std::vector<FinishedFrame>> FinishedFrames(uint64_t key) = 0;
};

}  // namespace shutterline::server
