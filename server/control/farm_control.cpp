// The part of Farm by which clients steer jobs.
#include <absl/strings/str_cat.h>
#include <spdlog/spdlog.h>

#include "common/base/status_macros.h"
#include "server/control/farm.h"

namespace shutterline::server {

absl::StatusOr<JobSnapshot> Farm::Cancel(const std::string& job_id) {
  absl::MutexLock control_lock(&control_mutex_);
  SL_ASSIGN_OR_RETURN(const JobPtr job, Find(job_id));
  SL_RETURN_IF_ERROR(EndJobLocked(job, JobState::kCancelled, ""));
  absl::MutexLock lock(&mutex_);
  return Snapshot(*job);
}

absl::StatusOr<JobSnapshot> Farm::SetPaused(const std::string& job_id, bool paused) {
  absl::MutexLock control_lock(&control_mutex_);
  SL_ASSIGN_OR_RETURN(const JobPtr job, Find(job_id));
  {
    absl::MutexLock lock(&mutex_);
    if (job->ending || job->snapshot().paused == paused) return Snapshot(*job);
  }
  SL_RETURN_IF_ERROR(parts_.store->SetPaused(job->key(), paused));
  JobSnapshot snapshot;
  {
    absl::MutexLock lock(&mutex_);
    job->SetPaused(paused, NextSeq());
    scheduler_.SetBlocked(job->key(), TileScheduler::Block::kPaused, paused);
    if (paused) {
      const std::vector<EndedLease> revoked = scheduler_.EndLeases(job->key());
      observer_.OnLeasesEnded(FarmObserver::LeaseEnd::kRevoked, int64_t(revoked.size()));
      Revoke(revoked);
    }
    Notify(*job);
    Pump();
    snapshot = Snapshot(*job);
  }
  if (paused) parts_.blocks->DropJob(job->key());  // Memory is for those that go on.
  spdlog::info("job {} job={}", paused ? "paused" : "resumed", job->id());
  return snapshot;
}

absl::StatusOr<JobSnapshot> Farm::SetPriority(const std::string& job_id, int priority) {
  if (priority < -kMaxPriority || priority > kMaxPriority) {
    return absl::InvalidArgumentError(
        absl::StrCat("priority: is ", priority, ", but must be ", -kMaxPriority, " to ", kMaxPriority));
  }
  absl::MutexLock control_lock(&control_mutex_);
  SL_ASSIGN_OR_RETURN(const JobPtr job, Find(job_id));
  {
    absl::MutexLock lock(&mutex_);
    if (job->snapshot().wishes.priority == priority) return Snapshot(*job);
  }
  SL_RETURN_IF_ERROR(parts_.store->SetPriority(job->key(), priority));
  absl::MutexLock lock(&mutex_);
  job->SetPriority(priority, NextSeq());
  scheduler_.SetPriority(job->key(), priority);
  Notify(*job);
  spdlog::info("job has another priority job={} priority={}", job->id(), priority);
  return Snapshot(*job);
}

absl::StatusOr<JobSnapshot> Farm::Retry(const std::string& job_id) {
  absl::MutexLock control_lock(&control_mutex_);
  SL_ASSIGN_OR_RETURN(const JobPtr job, Find(job_id));
  bool ended = false;
  {
    absl::MutexLock lock(&mutex_);
    ended = HasEnded(job->state());
    const bool nothing = ended ? job->state() == JobState::kSucceeded : job->quarantined().empty();
    if (nothing) return Snapshot(*job);
  }
  if (!ended) {
    SL_RETURN_IF_ERROR(parts_.store->Retry(job->key()));
    absl::MutexLock lock(&mutex_);
    if (JobQueue* queue = scheduler_.Find(job->key())) queue->Release();
    job->ReleaseQuarantined([this]() ABSL_NO_THREAD_SAFETY_ANALYSIS { return NextSeq(); });
    Notify(*job);
    Pump();
    spdlog::info("quarantined tiles are tried again job={}", job->id());
    return Snapshot(*job);
  }
  const std::shared_ptr<const BlobPins> blobs = PinBlobs(*job->spec());  // Nothing is evicted from here on.
  SL_RETURN_IF_ERROR(CheckBlobs(*job->spec()));
  SL_RETURN_IF_ERROR(parts_.store->Retry(job->key()));
  SL_ASSIGN_OR_RETURN(const JobRecord record, parts_.store->Get(job_id));
  SL_RETURN_IF_ERROR(ResumeJob(record));
  absl::MutexLock lock(&mutex_);
  const JobPtr again = FindLive(job_id);
  if (again == nullptr) return absl::InternalError(absl::StrCat("job ", job_id, " was not taken up"));
  Notify(*again);
  return Snapshot(*again);
}

void Farm::StartDependents(const std::string& job_id) {
  for (auto& [id, job] : jobs_) {
    if (job->ending || !job->WaitsNoMoreFor(job_id, NextSeq())) continue;
    if (job->snapshot().waits_for.empty()) {
      scheduler_.SetBlocked(job->key(), TileScheduler::Block::kDependencies, false);
      spdlog::info("job need not wait any more job={}", id);
    }
  }
}

void Farm::Schedule(LiveJob& job, const std::vector<std::string>& waits_for) {
  const TileGrid grid = job.grid();
  const JobSnapshot& snapshot = job.snapshot();
  scheduler_.AddJob(job.key(), job.frame_count(), grid.Columns(), grid.Rows(), snapshot.wishes.priority,
                    snapshot.wishes.user, job.spec()->order);
  scheduler_.SetBlocked(job.key(), TileScheduler::Block::kPaused, snapshot.paused);
  scheduler_.SetBlocked(job.key(), TileScheduler::Block::kDependencies, !waits_for.empty());
  for (const std::string& id : waits_for) job.WaitFor(id, NextSeq());
}

}  // namespace shutterline::server
