#include "server/control/farm.h"

#include <absl/strings/str_cat.h>
#include <spdlog/spdlog.h>

#include "common/base/log.h"
#include "common/base/status_macros.h"
#include "server/assemble/frame_assembler.h"
#include "server/files/file.h"

namespace shutterline::server {
namespace {

/// Jobs that have ended and are kept in memory; others are read from the store again.
constexpr size_t kEndedInMemory = 256;

SchedulerOptions OptionsOf(const Config& config) {
  SchedulerOptions options;
  options.lease_ttl = config.lease_ttl;
  options.stream_grace = config.stream_grace;
  options.batch_time = config.batch_time;
  options.max_tile_failures = config.max_tile_failures;
  return options;
}

absl::string_view WordOf(JobState state) {
  switch (state) {
    case JobState::kQueued:
      return "queued";
    case JobState::kRunning:
      return "running";
    case JobState::kSucceeded:
      return "succeeded";
    case JobState::kFailed:
      return "failed";
    case JobState::kCancelled:
      return "cancelled";
  }
  return "unknown";
}

}  // namespace

Farm::Farm(Parts parts)
    : parts_(std::move(parts)),
      scheduler_(*parts_.clock, OptionsOf(parts_.config)),
      registry_(parts_.identity),
      // Numbers of a later epoch are larger than any of an earlier one: an epoch would need 2^40 changes.
      last_seq_(parts_.epoch << 40) {}

Farm::~Farm() = default;

uint64_t Farm::NextSeq() {
  return ++last_seq_;
}

std::string Farm::FramePath(const LiveJob& job, int index) const {
  return absl::StrCat(parts_.frames_folder, "/", job.id(), "/", job.spec()->frames.Frame(index), ".exr");
}

void Farm::Notify(LiveJob& job) {
  job.dirty = false;
  for (JobWatcher* watcher : job.watchers) watcher->OnChange();
}

absl::Status Farm::Resume() {
  SL_ASSIGN_OR_RETURN(const std::vector<JobRecord> unfinished, parts_.store->Unfinished());
  for (const JobRecord& record : unfinished) SL_RETURN_IF_ERROR(ResumeJob(record));
  for (const TileJournal::FrameKey& frame : parts_.journal->Frames()) {
    absl::MutexLock lock(&mutex_);
    if (!by_key_.contains(frame.first)) parts_.journal->DropFrame(frame);
  }
  return absl::OkStatus();
}

absl::Status Farm::ResumeJob(const JobRecord& record) {
  SL_ASSIGN_OR_RETURN(const std::vector<FinishedFrame> finished, parts_.store->FinishedFrames(record.key));
  std::vector<int> complete;
  JobPtr job;
  {
    absl::MutexLock lock(&mutex_);
    job = std::make_shared<LiveJob>(record, NextSeq());
    jobs_[job->id()] = by_key_[job->key()] = job;
    const TileGrid grid = job->grid();
    scheduler_.AddJob(job->key(), job->frame_count(), grid.Columns(), grid.Rows());
    JobQueue& queue = *scheduler_.Find(job->key());
    for (const FinishedFrame& frame : finished) {
      const std::optional<int64_t> index = record.spec.frames.IndexOf(frame.frame);
      if (!index) return absl::DataLossError(absl::StrCat("job ", record.id, " has no frame ", frame.frame));
      const absl::StatusOr<File> file = File::OpenToRead(FramePath(*job, int(*index)));
      const absl::StatusOr<uint64_t> size =
          file.ok() ? file->Size() : absl::StatusOr<uint64_t>(file.status());
      if (!size.ok() || *size != frame.size) {
        spdlog::error("finished frame is missing and will be rendered again job={} frame={}", record.id,
                      frame.frame);
        SL_RETURN_IF_ERROR(parts_.store->RemoveFinishedFrame(record.key, frame.frame));
        continue;
      }
      queue.MarkFrameDone(int(*index));
      job->FrameFinished(int(*index), frame, NextSeq(), NextSeq());
      parts_.journal->DropFrame({record.key, int(*index)});
    }
    for (const TileJournal::FrameKey& frame : parts_.journal->Frames()) {
      if (frame.first != record.key) continue;
      for (const uint32_t tile : parts_.journal->Tiles(frame)) {
        if (!queue.Contains(frame.second, tile)) {
          parts_.journal->Forget({frame.first, frame.second, tile});
        } else if (queue.MarkDone(frame.second, tile)) {
          // What it took went with the last coordinator: the journal holds pixels alone.
          job->TileDone(frame.second, {}, NextSeq(), NextSeq());
        }
      }
      if (queue.DoneInFrame(frame.second) == grid.Count()) complete.push_back(frame.second);
    }
    spdlog::info("job taken up again job={} frames_finished={} tiles_done={} tiles={}", record.id,
                 job->snapshot().frames_finished, job->snapshot().tiles_done, job->snapshot().tiles_total);
  }
  for (const int frame : complete) WriteFrameSoon(job, frame);
  bool all_finished = false;
  {
    absl::MutexLock lock(&mutex_);
    all_finished = job->AllFinished();
  }
  // The coordinator ended between the last frame and the job's end.
  return all_finished ? EndJob(job, JobState::kSucceeded, "") : absl::OkStatus();
}

absl::Status Farm::EndJob(const JobPtr& job, JobState state, const std::string& error) {
  absl::MutexLock end_lock(&end_mutex_);
  {
    absl::MutexLock lock(&mutex_);
    if (HasEnded(job->state())) return absl::OkStatus();
    job->ending = true;
    Revoke(scheduler_.RemoveJob(job->key()));
  }
  const absl::Time now = parts_.clock->Wall();
  const absl::Status stored = parts_.store->End(job->key(), state, error, now);
  if (!stored.ok()) {
    // The job stands still until the next start, which takes it up again.
    spdlog::error("job's end could not be stored job={} reason={}", job->id(), LogValue(stored.message()));
    return stored;
  }
  parts_.journal->DropJob(job->key());
  absl::MutexLock lock(&mutex_);
  job->End(state, error, now, NextSeq());
  for (auto& [id, session] : sessions_) {
    if (session.announced.erase(job->id()) > 0 && session.sink != nullptr)
      session.sink->Send(JobForgotten{job->id()});
  }
  Notify(*job);
  ended_.push_back(job->id());
  ForgetOldJobs();
  Pump();
  spdlog::info("job ended job={} state={} error={}", job->id(), std::string(WordOf(state)), LogValue(error));
  return absl::OkStatus();
}

void Farm::EndPoisoned(const std::vector<PoisonedTile>& poisoned) {
  for (const PoisonedTile& tile : poisoned) {
    JobPtr job;
    {
      absl::MutexLock lock(&mutex_);
      const auto found = by_key_.find(tile.job);
      if (found == by_key_.end()) continue;
      job = found->second;
    }
    const std::string error = absl::StrCat("frame ", job->spec()->frames.Frame(tile.frame), ", tile ",
                                           tile.tile, ": ", tile.reason);
    (void)EndJob(job, JobState::kFailed, error);  // Logged there.
  }
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

void Farm::WriteFrameSoon(const JobPtr& job, int index) {
  parts_.frames_pool->Run([this, job, index] { WriteFrame(job, index); });
}

void Farm::WriteFrame(const JobPtr& job, int index) {
  const int number = job->spec()->frames.Frame(index);
  FinishedFrame finished;
  finished.frame = number;
  {
    absl::MutexLock lock(&mutex_);
    if (job->ending) return;
    finished.stats = job->Frame(index).stats;  // All its tiles have come.
  }
  const std::string path = FramePath(*job, index);
  const auto write = [&]() -> absl::StatusOr<AssembledFrame> {
    SL_RETURN_IF_ERROR(MakeFolders(path.substr(0, path.rfind('/'))));
    const FrameFacts facts{
        .names = [&] { return parts_.matte_names(*job->spec(), *parts_.assets); },
        .camera = [&] { return parts_.camera(*job->spec(), *parts_.assets, number); },
    };
    SL_ASSIGN_OR_RETURN(AssembledFrame frame,
                        AssembleFrame(*parts_.journal, {job->key(), index}, *job->spec(), facts, path));
    if (frame.lost_tiles.empty()) {
      finished.digest = frame.digest;
      finished.size = frame.size;
      SL_RETURN_IF_ERROR(parts_.store->AddFinishedFrame(job->key(), finished));
    }
    return frame;
  };
  const absl::StatusOr<AssembledFrame> frame = write();
  if (!frame.ok()) {
    (void)EndJob(job, JobState::kFailed,
                 absl::StrCat("write frame ", number, ": ", frame.status().message()));
    return;
  }
  bool all_finished = false;
  {
    absl::MutexLock lock(&mutex_);
    if (!frame->lost_tiles.empty()) {
      spdlog::error("journal lost tiles, which are rendered again job={} frame={} tiles={}", job->id(),
                    number, frame->lost_tiles.size());
      for (const uint32_t tile : frame->lost_tiles) parts_.journal->Forget({job->key(), index, tile});
      if (JobQueue* queue = scheduler_.Find(job->key())) {
        queue->Reopen(index, frame->lost_tiles);
        job->TilesLost(index, int(frame->lost_tiles.size()), NextSeq(), NextSeq());
        Pump();
      }
      return;
    }
    job->FrameFinished(index, finished, NextSeq(), NextSeq());
    all_finished = job->AllFinished();
    spdlog::info("frame finished job={} frame={} bytes={}", job->id(), number, frame->size);
  }
  parts_.journal->DropFrame({job->key(), index});
  if (all_finished) (void)EndJob(job, JobState::kSucceeded, "");  // Logged there.
}

void Farm::Tick() {
  TileScheduler::Expired expired;
  {
    absl::MutexLock lock(&mutex_);
    expired = scheduler_.Expire();
    if (!expired.leases.empty()) {
      spdlog::warn("leases ran out leases={} workers_lost={}", expired.leases.size(), expired.workers.size());
    }
    Revoke(expired.leases);
    for (const WorkerId worker : expired.workers)
      DropWorker(worker, absl::AbortedError("the session is over"));
    const absl::Duration now = parts_.clock->Monotonic();
    std::vector<WorkerId> never_came;
    for (const auto& [id, entry] : registry_.entries()) {
      if (!sessions_.contains(id) && now - entry.registered > parts_.config.lease_ttl)
        never_came.push_back(id);
    }
    for (const WorkerId id : never_came) registry_.Remove(id);
    for (const auto& [id, job] : jobs_) {
      if (job->dirty) Notify(*job);
    }
    Pump();
  }
  EndPoisoned(expired.poisoned);
}

}  // namespace shutterline::server
