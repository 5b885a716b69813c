#include "server/control/farm.h"

#include <absl/cleanup/cleanup.h>
#include <absl/strings/str_cat.h>
#include <spdlog/spdlog.h>

#include <algorithm>

#include "common/base/log.h"
#include "common/base/status_macros.h"
#include "server/assemble/frame_assembler.h"
#include "server/files/file.h"
#include "server/jobs/job_state_words.h"

namespace shutterline::server {
namespace {

/// Jobs that have ended and are kept in memory; others are read from the store again.
constexpr size_t kEndedInMemory = 256;

/// How long to wait before the disk is asked again, after so many refusals in a row.
absl::Duration RetryDelay(int failures) {
  return std::min(absl::Milliseconds(250) * (1 << std::min(failures, 10)), absl::Seconds(5));
}

/// Troubles of the disk that pass: full, or busy.
bool MayPass(const absl::Status& status) {
  return absl::IsResourceExhausted(status) || absl::IsUnavailable(status);
}

SchedulerOptions OptionsOf(const Config& config) {
  SchedulerOptions options;
  options.lease_ttl = config.lease_ttl;
  options.stream_grace = config.stream_grace;
  options.batch_time = config.batch_time;
  options.speculate_after = config.speculate_after;
  options.max_tile_failures = config.max_tile_failures;
  options.max_tile_deaths = config.max_tile_deaths;
  return options;
}

FarmObserver& Nobody() {
  static auto* const nobody = new FarmObserver();
  return *nobody;
}

}  // namespace

Farm::Farm(Parts parts)
    : parts_(std::move(parts)),
      observer_(parts_.observer != nullptr ? *parts_.observer : Nobody()),
      later_(*parts_.clock),
      scheduler_(*parts_.clock, OptionsOf(parts_.config)),
      registry_(parts_.identity),
      gather_ns_(absl::ToInt64Nanoseconds(GatherPaceOptions().least)),
      // Numbers of a later epoch are larger than any of an earlier one: an epoch would need 2^40 changes.
      last_seq_(parts_.epoch << 40) {}

Farm::~Farm() = default;

uint64_t Farm::NextSeq() {
  return ++last_seq_;
}

std::string Farm::FramePath(const std::string& job_id, int frame) const {
  return absl::StrCat(parts_.frames_folder, "/", job_id, "/", frame, ".exr");
}

std::string Farm::FramePath(const LiveJob& job, int index) const {
  return FramePath(job.id(), job.spec()->frames.Frame(index));
}

void Farm::Notify(LiveJob& job) {
  job.dirty = false;
  for (JobWatcher* watcher : job.watchers) watcher->OnChange();
}

absl::Status Farm::EndJob(const JobPtr& job, JobState state, const std::string& error) {
  absl::MutexLock control_lock(&control_mutex_);
  return EndJobLocked(job, state, error);
}

absl::Status Farm::EndJobLocked(const JobPtr& job, JobState state, const std::string& error) {
  {
    absl::MutexLock lock(&mutex_);
    if (HasEnded(job->state())) return absl::OkStatus();
    job->ending = true;
    const std::vector<EndedLease> revoked = scheduler_.RemoveJob(job->key());
    observer_.OnLeasesEnded(FarmObserver::LeaseEnd::kRevoked, int64_t(revoked.size()));
    Revoke(revoked);
  }
  const absl::Time now = parts_.clock->Wall();
  const absl::Status stored = parts_.store->End(job->key(), state, error, now);
  if (!stored.ok()) {
    // The job stands still until its end can be stored, or until the next start, which takes it up again.
    spdlog::error("job's end could not be stored job={} reason={}", job->id(), LogValue(stored.message()));
    if (MayPass(stored)) {
      later_.Add(absl::Seconds(1), [this, job, state, error] {
        parts_.frames_pool->Run([this, job, state, error] { (void)EndJob(job, state, error); });
      });
    }
    return stored;
  }
  // A retry of a partial job needs the tiles of its partial frames.
  if (state != JobState::kPartial) parts_.journal->DropJob(job->key());
  parts_.blocks->DropJob(job->key());
  absl::MutexLock lock(&mutex_);
  job->End(state, error, now, NextSeq());
  observer_.OnJobEnded(job->id(), state);
  if (state == JobState::kSucceeded) StartDependents(job->id());
  for (auto& [id, session] : sessions_) {
    if (session.announced.erase(job->id()) > 0 && session.sink != nullptr)
      session.sink->Send(JobForgotten{job->id()});
  }
  Notify(*job);
  ended_.push_back(job->id());
  ForgetOldJobs();
  Pump();
  spdlog::info("job ended job={} state={} error={}", job->id(), std::string(JobStateWord(state)),
               LogValue(error));
  return absl::OkStatus();
}

void Farm::ForgetOldJobs() {
  for (size_t examined = ended_.size(); ended_.size() > kEndedInMemory && examined > 0; --examined) {
    const std::string id = ended_.front();
    ended_.pop_front();
    const auto found = jobs_.find(id);
    if (found == jobs_.end()) continue;
    if (!found->second->watchers.empty()) {
      ended_.push_back(id);
      continue;
    }
    by_key_.erase(found->second->key());
    jobs_.erase(found);
  }
}

void Farm::WriteFrameSoon(const JobPtr& job, int index, int failures) {
  parts_.frames_pool->Run([this, job, index, failures] { WriteFrame(job, index, failures); });
}

void Farm::WriteFrame(const JobPtr& job, int index, int failures) {
  const int number = job->spec()->frames.Frame(index);
  FinishedFrame finished;
  finished.frame = number;
  std::set<uint32_t> missing;
  const absl::Cleanup written = [this, job]() ABSL_NO_THREAD_SAFETY_ANALYSIS {
    absl::MutexLock lock(&mutex_);
    const auto count = writing_.find(job->key());
    if (count != writing_.end() && --count->second == 0) writing_.erase(count);
  };
  {
    absl::MutexLock lock(&mutex_);
    ++writing_[job->key()];
    if (job->ending) return;
    finished.stats = job->Frame(index).stats;  // All its tiles have come.
    missing = job->Missing(index);
    finished.missing = int(missing.size());
  }
  const absl::Duration began = parts_.clock->Monotonic();
  const std::string path = FramePath(*job, index);
  const auto write = [&]() -> absl::StatusOr<AssembledFrame> {
    const Durability durability = parts_.config.durability;
    SL_RETURN_IF_ERROR(MakeFolders(path.substr(0, path.rfind('/')), durability));
    const FrameFacts facts{
        .names = [&] { return parts_.matte_names(*job->spec(), *parts_.assets); },
        .camera = [&] { return parts_.camera(*job->spec(), *parts_.assets, number); },
    };
    return AssembleFrame(*parts_.journal, {job->key(), index}, *job->spec(), missing,
                         parts_.blocks->Take({job->key(), index}), facts, path, durability);
  };
  const absl::StatusOr<AssembledFrame> frame = write();
  if (frame.ok() && !frame->lost_tiles.empty()) {
    absl::MutexLock lock(&mutex_);
    spdlog::error("journal lost tiles, which are rendered again job={} frame={} tiles={}", job->id(), number,
                  frame->lost_tiles.size());
    for (const uint32_t tile : frame->lost_tiles) parts_.journal->Forget({job->key(), index, tile});
    JobQueue* queue = scheduler_.Find(job->key());
    if (job->ending || queue == nullptr) return;
    queue->Reopen(index, frame->lost_tiles);
    job->TilesLost(index, int(frame->lost_tiles.size()), NextSeq(), NextSeq());
    Pump();
    return;
  }

  absl::MutexLock control_lock(&control_mutex_);
  {
    absl::MutexLock lock(&mutex_);
    // It has ended meanwhile, or a retry waits for what was missing: then the frame will be written again.
    if (job->ending || job->Missing(index) != missing) return;
  }
  absl::Status stored = frame.status();
  if (stored.ok()) {
    finished.digest = frame->digest;
    finished.size = frame->size;
    stored = parts_.store->AddFinishedFrame(job->key(), finished);
  }
  if (!stored.ok() && MayPass(stored)) {
    const absl::Duration delay = RetryDelay(failures);
    spdlog::warn("frame could not be written, trying again job={} frame={} delay_ms={} reason={}", job->id(),
                 number, absl::ToInt64Milliseconds(delay), LogValue(stored.message()));
    later_.Add(delay, [this, job, index, failures] { WriteFrameSoon(job, index, failures + 1); });
    return;
  }
  if (!stored.ok()) {
    // Logged there.
    (void)EndJobLocked(job, JobState::kFailed, absl::StrCat("write frame ", number, ": ", stored.message()));
    return;
  }
  bool all_finished = false;
  {
    absl::MutexLock lock(&mutex_);
    job->FrameFinished(index, finished, NextSeq(), NextSeq());
    all_finished = job->AllFinished();
    observer_.OnFrameWritten({job->id(), number, frame->size, began, parts_.clock->Monotonic()});
    spdlog::info("frame finished job={} frame={} bytes={} missing={}", job->id(), number, frame->size,
                 missing.size());
  }
  if (missing.empty()) parts_.journal->DropFrame({job->key(), index});
  if (all_finished) (void)EndFinishedJob(job);  // Logged there.
}

void Farm::Tick() {
  for (const std::function<void()>& task : later_.TakeDue()) task();
  TileScheduler::Expired expired;
  std::map<std::string, bool> notes;
  {
    absl::MutexLock lock(&mutex_);
    expired = scheduler_.Expire();
    for (const EndedLease& lease : expired.leases)
      spdlog::warn("lease ran out lease={} worker={}", lease.id, WorkerName(lease.worker));
    for (const WorkerId worker : expired.workers) spdlog::warn("worker lost worker={}", WorkerName(worker));
    observer_.OnLeasesEnded(FarmObserver::LeaseEnd::kExpired, int64_t(expired.leases.size()));
    Revoke(expired.leases);
    for (const WorkerId worker : expired.workers)
      DropWorker(worker, absl::AbortedError("the session is over"));
    const absl::Duration now = parts_.clock->Monotonic();
    if (now >= next_roll_call_) {
      next_roll_call_ = now + absl::Seconds(1);
      std::vector<WorkerId> never_came;
      for (const auto& [id, entry] : registry_.entries()) {
        if (!sessions_.contains(id) && now - entry.registered > parts_.config.lease_ttl)
          never_came.push_back(id);
      }
      for (const WorkerId id : never_came) registry_.Remove(id);
    }
    for (const auto& [id, job] : jobs_) {
      if (job->dirty) Notify(*job);
    }
    if (!awaited_.empty() && now >= await_until_) EndAdoption();
    Pump();
    gather_pace_.Tick(now, int64_t(sessions_.size()));
    gather_ns_ = absl::ToInt64Nanoseconds(gather_pace_.gather());
    Speculate();
    for (std::vector<Quarantined>* more : {&buried_, &unstored_}) {
      expired.quarantined.insert(expired.quarantined.end(), more->begin(), more->end());
      more->clear();
    }
    notes = std::exchange(worker_notes_, {});
  }
  Quarantine(expired.quarantined);
  if (notes.empty()) return;
  const absl::Status noted = parts_.store->NoteWorkers(notes);
  // The next coordinator will not wait for some, or wait for some in vain.
  if (!noted.ok()) spdlog::warn("workers could not be noted reason={}", LogValue(noted.message()));
}

}  // namespace shutterline::server
