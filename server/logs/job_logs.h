#pragma once

#include <absl/base/thread_annotations.h>
#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>
#include <absl/synchronization/mutex.h>

#include <cstdint>
#include <list>
#include <memory>
#include <string>
#include <utility>

#include "common/base/log.h"
#include "server/files/file.h"

namespace shutterline::server {

/// What the coordinator's log says about each job, for people: every line of level info and above that has a
/// field job=UUID goes to that job's own file as well.
///
/// A file survives restarts; it is not synced, so a power cut may take its last lines. When it
/// has grown beyond `max_bytes`, a last line says that it is full. Where the disk refuses lines, the next
/// that it takes is preceded by a line that counts those that are missing. Thread-safe.
class JobLogs final : private LogListener {
 public:
  struct Options {
    uint64_t max_bytes = uint64_t{8} << 20;  ///< Of a job.
    size_t max_open_files = 16;
  };
  /// Makes the folder if it is missing, and listens to the log for as long as it lives.
  static absl::StatusOr<std::unique_ptr<JobLogs>> Open(const std::string& folder, const Options& options);
  ~JobLogs() override;

  /// Up to `count` bytes from `offset`; none where the log ends there, or the job has none.
  absl::StatusOr<std::string> Read(const std::string& job_id, uint64_t offset, size_t count) const;
  /// Removes the job's log, as durably as is asked; OK also where there is none. What the log says of the job
  /// from then on makes a new one.
  absl::Status Remove(const std::string& job_id, Durability durability);

 private:
  struct OpenLog {
    std::string job_id;
    File file;
    uint64_t size = 0;
  };
  JobLogs(std::string folder, const Options& options) : folder_(std::move(folder)), options_(options) {}

  void OnLogLine(absl::string_view line, absl::string_view message) override;
  std::string Path(absl::string_view job_id) const;
  absl::StatusOr<OpenLog*> Find(absl::string_view job_id) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  absl::Status Append(absl::string_view job_id, absl::string_view line) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const std::string folder_;
  const Options options_;
  absl::Mutex mutex_;
  std::list<OpenLog> open_ ABSL_GUARDED_BY(mutex_);  ///< Latest used first.
  int64_t missing_ ABSL_GUARDED_BY(mutex_) = 0;      ///< Lines that the disk has refused.
};

}  // namespace shutterline::server
