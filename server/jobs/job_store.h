#pragma once

#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>
#include <absl/time/time.h>

#include <cstdint>
#include <string>
#include <vector>

#include "common/asset/digest.h"
#include "common/job/job_spec.h"
#include "common/job/render_stats.h"

namespace shutterline::server {

/// Numbers are stored: never change one.
enum class JobState { kQueued = 1, kRunning = 2, kSucceeded = 3, kFailed = 4, kCancelled = 5 };

inline bool HasEnded(JobState state) {
  return state == JobState::kSucceeded || state == JobState::kFailed || state == JobState::kCancelled;
}

/// A job as it is on disk. That it is running is not stored: a job that has not ended is queued.
struct JobRecord {
  uint64_t key = 0;  ///< Grows with every job.
  std::string id;    ///< A UUID.
  std::string request_id;
  JobSpec spec;
  JobState state = JobState::kQueued;
  std::string error;
  absl::Time submitted;
  absl::Time ended = absl::InfinitePast();  ///< InfinitePast: it has not.
};

/// The EXR of a finished frame.
struct FinishedFrame {
  int frame = 0;  ///< The frame's number.
  Digest digest;
  uint64_t size = 0;  ///< Bytes.
  RenderStats stats;  ///< What its tiles took; zeros where that is not known.
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
                                         absl::Time now) = 0;
  virtual absl::StatusOr<JobRecord> Get(absl::string_view id) = 0;
  /// NOT_FOUND where the request id has not been used.
  virtual absl::StatusOr<JobRecord> FindRequest(absl::string_view request_id) = 0;
  /// Up to `limit` jobs with smaller keys than `before`, latest first.
  virtual absl::StatusOr<std::vector<JobRecord>> List(uint64_t before, int limit) = 0;
  /// All jobs that have not ended, oldest first.
  virtual absl::StatusOr<std::vector<JobRecord>> Unfinished() = 0;

  /// Ends the job. A job that has ended stays as it is.
  virtual absl::Status End(uint64_t key, JobState state, const std::string& error, absl::Time now) = 0;

  virtual absl::Status AddFinishedFrame(uint64_t key, const FinishedFrame& frame) = 0;
  virtual absl::Status RemoveFinishedFrame(uint64_t key, int frame) = 0;
  /// By frame number.
  virtual absl::StatusOr<std::vector<FinishedFrame>> FinishedFrames(uint64_t key) = 0;
};

}  // namespace shutterline::server
