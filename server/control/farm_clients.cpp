// The part of Farm that clients use.
#include <absl/strings/escaping.h>
#include <absl/strings/str_cat.h>
#include <spdlog/spdlog.h>

#include <set>

#include "common/base/ids.h"
#include "common/base/log.h"
#include "common/base/status_macros.h"
#include "server/control/farm.h"

namespace shutterline::server {
namespace {

constexpr size_t kMaxRequestIdBytes = 128;

absl::Status WasRemoved(const RemovedJob& job) {
  return absl::NotFoundError(
      absl::StrCat("job ", job.id, " was removed at ",
                   absl::FormatTime("%Y-%m-%dT%H:%M:%SZ", job.removed, absl::UTCTimeZone())));
}

bool SameBody(const JobRecord& job, const JobSpec& spec, const JobWishes& wishes) {
  // The priority may have been changed since.
  return job.spec == spec && job.wishes.user == wishes.user && job.wishes.after == wishes.after;
}

absl::Status OtherBody(const JobRecord& job) {
  return absl::AlreadyExistsError(absl::StrCat("request_id '", absl::CHexEscape(job.request_id),
                                               "' has been used for another specification, job ", job.id));
}

}  // namespace

absl::Status Farm::NoSuchJob(const std::string& job_id) {
  if (IsUuid(job_id)) {
    const absl::StatusOr<RemovedJob> removed = parts_.store->FindRemoved(job_id);
    if (removed.ok()) return WasRemoved(*removed);
    if (!absl::IsNotFound(removed.status())) return removed.status();
  }
  return absl::NotFoundError(
      absl::StrCat("there is no job '", absl::CHexEscape(absl::string_view(job_id).substr(0, 80)), "'"));
}

absl::StatusOr<JobState> Farm::StoredState(const std::string& job_id) {
  const absl::StatusOr<JobRecord> job = parts_.store->Get(job_id);
  if (job.ok()) return job->state;
  if (!absl::IsNotFound(job.status())) return job.status();
  SL_ASSIGN_OR_RETURN(const RemovedJob removed, parts_.store->FindRemoved(job_id));
  return removed.state;
}

Farm::JobPtr Farm::FindLive(const std::string& job_id) {
  const auto found = jobs_.find(job_id);
  return found == jobs_.end() ? nullptr : found->second;
}

absl::StatusOr<Farm::JobPtr> Farm::Load(const JobRecord& record) {
  SL_ASSIGN_OR_RETURN(const std::vector<FinishedFrame> finished, parts_.store->FinishedFrames(record.key));
  SL_ASSIGN_OR_RETURN(const std::vector<QuarantinedTile> quarantined,
                      parts_.store->QuarantinedTiles(record.key));
  absl::MutexLock lock(&mutex_);
  if (JobPtr job = FindLive(record.id)) return job;
  if (removed_.contains(record.key)) {
    return absl::NotFoundError(absl::StrCat("job ", record.id, " has just been removed"));
  }
  // Its end was stored between two looks into memory, or it was forgotten; it cannot be unfinished, for those
  // are always in memory, but for a moment in Submit.
  if (!HasEnded(record.state))
    return absl::UnavailableError(absl::StrCat("job ", record.id, " is being accepted"));
  auto job = std::make_shared<LiveJob>(record, NextSeq());
  for (const QuarantinedTile& tile : quarantined) {
    if (const std::optional<int64_t> index = record.spec.frames.IndexOf(tile.frame)) {
      job->TileQuarantined(int(*index), tile, NextSeq(), NextSeq());
    }
  }
  for (const FinishedFrame& frame : finished) {
    if (const std::optional<int64_t> index = record.spec.frames.IndexOf(frame.frame)) {
      job->FrameFinished(int(*index), frame, NextSeq(), NextSeq());
    }
  }
  job->ending = true;
  job->dirty = false;
  jobs_[job->id()] = by_key_[job->key()] = job;
  ended_.push_back(job->id());
  ForgetOldJobs();
  return job;
}

absl::StatusOr<Farm::JobPtr> Farm::Find(const std::string& job_id) {
  if (!IsUuid(job_id)) return NoSuchJob(job_id);
  {
    absl::MutexLock lock(&mutex_);
    if (JobPtr job = FindLive(job_id)) return job;
  }
  const absl::StatusOr<JobRecord> record = parts_.store->Get(job_id);
  if (absl::IsNotFound(record.status())) return NoSuchJob(job_id);
  SL_RETURN_IF_ERROR(record.status());
  return Load(*record);
}

JobSnapshot Farm::Snapshot(const LiveJob& job) {
  JobSnapshot snapshot = job.snapshot();
  snapshot.workers = int(sessions_.size());
  return snapshot;
}

absl::Status Farm::CheckBlobs(const JobSpec& spec) {
  for (const SceneFile& file : spec.scene.files) {
    const std::string name = absl::CHexEscape(file.name);
    const absl::StatusOr<uint64_t> size = parts_.assets->Size(file.digest);
    if (absl::IsNotFound(size.status())) {
      return absl::FailedPreconditionError(absl::StrCat("scene file '", name, "': blob ", file.digest.ToHex(),
                                                        " is not here; upload it first"));
    }
    SL_RETURN_IF_ERROR(size.status());
    if (*size != file.size) {
      return absl::InvalidArgumentError(absl::StrCat("scene file '", name, "': size_bytes is ", file.size,
                                                     ", but blob ", file.digest.ToHex(), " has ", *size));
    }
  }
  return absl::OkStatus();
}

std::shared_ptr<const BlobPins> Farm::PinBlobs(const JobSpec& spec) {
  std::vector<Digest> digests;
  for (const SceneFile& file : spec.scene.files) digests.push_back(file.digest);
  return parts_.assets->Pin(std::move(digests));
}

absl::Status Farm::CheckWishes(const JobWishes& wishes) {
  if (wishes.priority < -kMaxPriority || wishes.priority > kMaxPriority) {
    return absl::InvalidArgumentError(absl::StrCat("priority: is ", wishes.priority, ", but must be ",
                                                   -kMaxPriority, " to ", kMaxPriority));
  }
  if (wishes.user.size() > kMaxUserBytes || wishes.user.find('\0') != std::string::npos) {
    return absl::InvalidArgumentError(absl::StrCat("user: has ", wishes.user.size(),
                                                   " bytes, but must have at most ", kMaxUserBytes,
                                                   ", none of them 0"));
  }
  if (wishes.after.size() > kMaxAfter) {
    return absl::InvalidArgumentError(
        absl::StrCat("after: names ", wishes.after.size(), " jobs, but may name at most ", kMaxAfter));
  }
  std::set<std::string> named;
  for (const std::string& id : wishes.after) {
    SL_RETURN_IF_ERROR(Annotate(Find(id).status(), "after"));
    if (!named.insert(id).second) {
      return absl::InvalidArgumentError(absl::StrCat("after: names job ", id, " twice"));
    }
  }
  return absl::OkStatus();
}

absl::Status Farm::CheckNotRemoved(const std::string& request_id) {
  // A request that is repeated late does not bring back what it made.
  const absl::StatusOr<RemovedJob> removed = parts_.store->FindRemovedRequest(request_id);
  if (removed.ok()) return Annotate(WasRemoved(*removed), "request_id has been used");
  return absl::IsNotFound(removed.status()) ? absl::OkStatus() : removed.status();
}

absl::StatusOr<JobSnapshot> Farm::Submit(const std::string& request_id, const JobSpec& spec,
                                         const JobWishes& wishes) {
  if (request_id.empty() || request_id.size() > kMaxRequestIdBytes) {
    return absl::InvalidArgumentError(absl::StrCat("request_id: has ", request_id.size(),
                                                   " bytes, but must have 1 to ", kMaxRequestIdBytes));
  }
  const absl::StatusOr<JobRecord> before = parts_.store->FindRequest(request_id);
  if (before.ok()) {
    if (!SameBody(*before, spec, wishes)) return OtherBody(*before);
    return Get(before->id);
  }
  if (!absl::IsNotFound(before.status())) return before.status();
  SL_RETURN_IF_ERROR(CheckNotRemoved(request_id));
  SL_RETURN_IF_ERROR(CheckWishes(wishes));
  std::shared_ptr<const BlobPins> blobs = PinBlobs(spec);  // First: what is seen stays.
  SL_RETURN_IF_ERROR(CheckBlobs(spec));
  SL_RETURN_IF_ERROR(parts_.check_scene(spec, *parts_.assets));

  // While this is held no job ends.
  absl::MutexLock control_lock(&control_mutex_);
  std::vector<std::string> waits_for;
  for (const std::string& id : wishes.after) {
    SL_ASSIGN_OR_RETURN(const JobPtr other, Find(id));
    absl::MutexLock lock(&mutex_);
    if (other->state() != JobState::kSucceeded) waits_for.push_back(id);
  }
  SL_RETURN_IF_ERROR(CheckNotRemoved(request_id));  // Again: the import may have taken minutes.
  SL_ASSIGN_OR_RETURN(const JobStore::Created created,
                      parts_.store->Create(request_id, spec, wishes, parts_.clock->Wall()));
  if (!created.is_new && !SameBody(created.job, spec, wishes)) return OtherBody(created.job);

  absl::MutexLock lock(&mutex_);
  if (const JobPtr job = FindLive(created.job.id)) return Snapshot(*job);
  const auto job = std::make_shared<LiveJob>(created.job, NextSeq());
  job->blobs = std::move(blobs);
  jobs_[job->id()] = by_key_[job->key()] = job;
  Schedule(*job, waits_for);
  observer_.OnJobAccepted(job->id());
  spdlog::info("job accepted job={} name={} frames={} tiles={} workers={}", job->id(), LogValue(spec.name),
               job->frame_count(), job->snapshot().tiles_total, sessions_.size());
  Pump();
  return Snapshot(*job);
}

absl::StatusOr<JobSnapshot> Farm::Get(const std::string& job_id) {
  SL_ASSIGN_OR_RETURN(const JobPtr job, Find(job_id));
  absl::MutexLock lock(&mutex_);
  return Snapshot(*job);
}

absl::StatusOr<std::vector<JobSnapshot>> Farm::List(uint64_t before, int limit) {
  SL_ASSIGN_OR_RETURN(const std::vector<JobRecord> records, parts_.store->List(before, limit));
  std::vector<JobSnapshot> jobs;
  for (const JobRecord& record : records) {
    const absl::StatusOr<JobPtr> job = Load(record);
    // Its Submit has not returned yet, or it has been removed since.
    if (absl::IsUnavailable(job.status()) || absl::IsNotFound(job.status())) continue;
    SL_RETURN_IF_ERROR(job.status());
    absl::MutexLock lock(&mutex_);
    jobs.push_back(Snapshot(**job));
  }
  return jobs;
}

absl::StatusOr<std::pair<FrameSnapshot, std::string>> Farm::FindFrame(const std::string& job_id, int frame) {
  SL_ASSIGN_OR_RETURN(const JobPtr job, Find(job_id));
  const std::optional<int64_t> index = job->spec()->frames.IndexOf(frame);
  if (!index) return absl::NotFoundError(absl::StrCat("job ", job_id, " has no frame ", frame));
  absl::MutexLock lock(&mutex_);
  const FrameSnapshot snapshot = job->Frame(int(*index));
  if (snapshot.state != FrameState::kFinished) {
    return absl::FailedPreconditionError(absl::StrCat("frame ", frame, " of job ", job_id,
                                                      " is not finished: ", snapshot.tiles_done, " of ",
                                                      snapshot.tiles_total, " tiles are done"));
  }
  return std::make_pair(snapshot, FramePath(*job, int(*index)));
}

std::vector<WorkerSnapshot> Farm::Workers() {
  absl::MutexLock lock(&mutex_);
  const absl::Duration now = parts_.clock->Monotonic();
  std::vector<WorkerSnapshot> workers;
  for (const auto& [id, entry] : registry_.entries()) {
    if (!entry.attached) continue;
    workers.push_back({entry.hello.uuid, entry.hello.name, entry.hello.build_id, entry.hello.isa,
                       entry.hello.slots, entry.draining, scheduler_.LeasedTiles(id), entry.tiles_done,
                       scheduler_.TileTime(id), now - entry.last_heard});
  }
  return workers;
}

absl::Status Farm::AddWatcher(const std::string& job_id, JobWatcher* watcher) {
  SL_ASSIGN_OR_RETURN(const JobPtr job, Find(job_id));
  absl::MutexLock lock(&mutex_);
  // It may have been forgotten since, or taken up again.
  if (removed_.contains(job->key())) {
    return absl::NotFoundError(absl::StrCat("job ", job_id, " has just been removed"));
  }
  JobPtr& live = jobs_[job->id()];
  if (live == nullptr) live = by_key_[job->key()] = job;
  live->watchers.insert(watcher);
  return absl::OkStatus();
}

void Farm::RemoveWatcher(const std::string& job_id, JobWatcher* watcher) {
  absl::MutexLock lock(&mutex_);
  if (const JobPtr job = FindLive(job_id)) job->watchers.erase(watcher);
}

std::optional<JobChange> Farm::NextChange(const std::string& job_id, uint64_t seq, bool& ended) {
  absl::MutexLock lock(&mutex_);
  const JobPtr job = FindLive(job_id);
  ended = job == nullptr || HasEnded(job->state());
  if (job == nullptr) return std::nullopt;
  std::optional<JobChange> change = job->NextChange(seq);
  if (change) {
    if (auto* snapshot = std::get_if<JobSnapshot>(&change->what)) snapshot->workers = int(sessions_.size());
  }
  return change;
}

}  // namespace shutterline::server
