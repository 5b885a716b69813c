// The part of Farm that those use who look at it: metrics and the dashboard.
#include <absl/strings/str_cat.h>

#include <algorithm>

#include "common/base/status_macros.h"
#include "server/control/farm.h"

namespace shutterline::server {

FarmTotals Farm::Totals() {
  absl::MutexLock lock(&mutex_);
  FarmTotals totals;
  for (const auto& [id, entry] : registry_.entries()) {
    if (!entry.attached) continue;
    ++totals.workers;
    totals.slots += entry.hello.slots;
    totals.draining_workers += entry.draining ? 1 : 0;
  }
  for (const auto& [id, job] : jobs_) {
    if (!HasEnded(job->state())) ++totals.jobs[job->state()];
  }
  const TileScheduler::Demand demand = scheduler_.Remaining();
  totals.queued_tiles = demand.queued;
  totals.leased_tiles = demand.remaining - demand.queued;
  totals.remaining_tiles = demand.remaining;
  totals.remaining_seconds = demand.seconds;
  totals.unmeasured_tiles = demand.unmeasured;
  return totals;
}

std::vector<std::pair<uint64_t, JobSnapshot>> Farm::ChangedJobs(uint64_t seq, size_t limit) {
  absl::MutexLock lock(&mutex_);
  std::vector<std::pair<uint64_t, const LiveJob*>> changed;
  for (const auto& [id, job] : jobs_) {
    if (job->seq() > seq) changed.emplace_back(job->seq(), job.get());
  }
  std::sort(changed.begin(), changed.end());
  if (changed.size() > limit) changed.resize(limit);
  std::vector<std::pair<uint64_t, JobSnapshot>> jobs;
  for (const auto& [at, job] : changed) jobs.emplace_back(at, Snapshot(*job));
  return jobs;
}

uint64_t Farm::LastSeq() {
  absl::MutexLock lock(&mutex_);
  return last_seq_;
}

absl::StatusOr<Farm::FrameView> Farm::ViewFrame(const std::string& job_id, int frame) {
  SL_ASSIGN_OR_RETURN(const JobPtr job, Find(job_id));
  const std::optional<int64_t> index = job->spec()->frames.IndexOf(frame);
  if (!index) return absl::NotFoundError(absl::StrCat("job ", job_id, " has no frame ", frame));
  absl::MutexLock lock(&mutex_);
  return FrameView{
      job->spec(), job->Frame(int(*index)), {job->key(), int(*index)}, FramePath(*job, int(*index))};
}

absl::StatusOr<std::vector<FrameSnapshot>> Farm::Frames(const std::string& job_id, int64_t first,
                                                        int64_t limit) {
  SL_ASSIGN_OR_RETURN(const JobPtr job, Find(job_id));
  absl::MutexLock lock(&mutex_);
  std::vector<FrameSnapshot> frames;
  const int64_t end = std::min<int64_t>(job->frame_count(), first + limit);
  for (int64_t i = std::max<int64_t>(0, first); i < end; ++i) frames.push_back(job->Frame(int(i)));
  return frames;
}

}  // namespace shutterline::server
