// The part of Farm that forgets jobs that have ended. First their place in the store, in one step, which
// leaves a note of their files; then the files; then the note says that they are gone. Whatever ends between
// two of these, the next coordinator finds the note.
#include <absl/strings/str_cat.h>
#include <spdlog/spdlog.h>

#include <algorithm>

#include "common/base/log.h"
#include "common/base/status_macros.h"
#include "server/control/farm.h"
#include "server/files/file.h"

namespace shutterline::server {
namespace {

/// Jobs that are looked at together, and removed at one look at most: frames are written by the same threads.
constexpr int kPage = 256;
/// While a frame is being written, and after the disk has refused.
constexpr absl::Duration kAgain = absl::Milliseconds(250), kLater = absl::Seconds(5);

}  // namespace

std::string Farm::WhoWaitsFor(const std::string& job_id) {
  const auto waits = std::find_if(jobs_.begin(), jobs_.end(), [&](const auto& entry) {
    const JobSnapshot& job = entry.second->snapshot();
    return !HasEnded(job.state) && job.waits_for.contains(job_id);
  });
  return waits == jobs_.end() ? "" : waits->first;
}

absl::StatusOr<JobSnapshot> Farm::Remove(const std::string& job_id) {
  absl::MutexLock control_lock(&control_mutex_);
  SL_ASSIGN_OR_RETURN(const JobPtr job, Find(job_id));
  JobSnapshot snapshot;
  {
    absl::MutexLock lock(&mutex_);
    snapshot = Snapshot(*job);
    if (!HasEnded(snapshot.state)) {
      return absl::FailedPreconditionError(absl::StrCat("job ", job_id, " has not ended: cancel it first"));
    }
    if (const std::string other = WhoWaitsFor(job_id); !other.empty()) {
      return absl::FailedPreconditionError(
          absl::StrCat("job ", other, " waits for job ", job_id, ": cancel that one first"));
    }
  }
  SL_RETURN_IF_ERROR(RemoveLocked(job->key(), job_id));
  return snapshot;
}

absl::Status Farm::RemoveLocked(JobKey key, const std::string& job_id) {
  SL_RETURN_IF_ERROR(parts_.store->Remove(key, parts_.clock->Wall()));
  {
    absl::MutexLock lock(&mutex_);
    removed_.insert(key);
    if (const JobPtr job = FindLive(job_id)) {
      jobs_.erase(job_id);
      by_key_.erase(key);
      std::erase(ended_, job_id);
      Notify(*job);  // Who watches it hears that it is over.
    }
    observer_.OnJobRemoved(job_id);
  }
  // Not job=: that would begin a new log of it.
  spdlog::info("job removed removed_job={}", job_id);
  RemoveFilesSoon(key, job_id, 0);
  return absl::OkStatus();
}

void Farm::RemoveFilesSoon(JobKey key, const std::string& job_id, int failures) {
  parts_.frames_pool->Run([this, key, job_id, failures] { RemoveFiles(key, job_id, failures); });
}

void Farm::RemoveFiles(JobKey key, const std::string& job_id, int failures) {
  {
    absl::MutexLock lock(&mutex_);
    // A frame of a job that was cancelled may be under way to its file.
    if (writing_.contains(key)) {
      later_.Add(kAgain, [this, key, job_id, failures] { RemoveFilesSoon(key, job_id, failures); });
      return;
    }
  }
  const auto remove = [&]() -> absl::Status {
    parts_.journal->DropJob(key);
    SL_RETURN_IF_ERROR(RemoveFolder(absl::StrCat(parts_.frames_folder, "/", job_id)));
    // Before the note goes: what a loss of power brought back would stay for ever.
    SL_RETURN_IF_ERROR(SyncFolder(parts_.frames_folder, parts_.config.durability));
    if (parts_.remove_log) SL_RETURN_IF_ERROR(parts_.remove_log(job_id));
    return parts_.store->FilesRemoved(job_id);
  };
  const absl::Status status = remove();
  if (status.ok()) return;
  if (failures == 0) {
    spdlog::warn("files of a removed job could not be removed, trying again removed_job={} reason={}", job_id,
                 LogValue(status.message()));
  }
  later_.Add(kLater, [this, key, job_id, failures] { RemoveFilesSoon(key, job_id, failures + 1); });
}

void Farm::RemoveOldJobs() {
  const absl::Status status = RemoveDueJobs();
  if (!status.ok()) spdlog::warn("old jobs could not be removed reason={}", LogValue(status.message()));
  later_.Add(parts_.config.removal_interval,
             [this] { parts_.frames_pool->Run([this] { RemoveOldJobs(); }); });
}

absl::Status Farm::RemoveDueJobs() {
  const Config& config = parts_.config;
  const absl::Time now = parts_.clock->Wall();
  SL_ASSIGN_OR_RETURN(int64_t surplus, parts_.store->CountEnded());
  surplus = config.keep_jobs_max > 0 ? surplus - config.keep_jobs_max : 0;
  EndedJob last;
  int removed = 0;
  while (true) {
    SL_ASSIGN_OR_RETURN(const std::vector<EndedJob> page, parts_.store->Ended(last, kPage));
    for (const EndedJob& job : page) {
      if (surplus <= 0 && now - job.ended <= config.keep_jobs) return absl::OkStatus();
      --surplus;
      absl::MutexLock control_lock(&control_mutex_);
      {
        absl::MutexLock lock(&mutex_);
        const JobPtr live = FindLive(job.id);
        // It is tried again; or its last events are under way, and its turn comes at the next look.
        if (live != nullptr && (!HasEnded(live->state()) || !live->watchers.empty())) continue;
        // Removed, it would never be what the other waits for.
        if (!WhoWaitsFor(job.id).empty()) continue;
      }
      const absl::Status status = RemoveLocked(job.key, job.id);
      if (absl::IsNotFound(status)) continue;  // Somebody else has just removed it.
      if (!status.ok()) {                      // Not in the way of the others.
        spdlog::warn("old job could not be removed job={} reason={}", job.id, LogValue(status.message()));
        continue;
      }
      if (++removed == kPage) return absl::OkStatus();
    }
    if (page.size() < size_t(kPage)) return absl::OkStatus();
    last = page.back();
  }
}

}  // namespace shutterline::server
