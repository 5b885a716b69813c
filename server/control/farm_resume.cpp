// The part of Farm that takes up jobs from the disk.
#include <absl/strings/str_cat.h>
#include <spdlog/spdlog.h>

#include <set>

#include "common/base/status_macros.h"
#include "server/control/farm.h"
#include "server/files/file.h"

namespace shutterline::server {

absl::Status Farm::Resume() {
  absl::MutexLock control_lock(&control_mutex_);
  SL_ASSIGN_OR_RETURN(const std::vector<JobRecord> unfinished, parts_.store->Unfinished());
  for (const JobRecord& record : unfinished) SL_RETURN_IF_ERROR(ResumeJob(record));
  // Tiles of partial frames are kept for a retry.
  SL_ASSIGN_OR_RETURN(const auto quarantined, parts_.store->QuarantinedFrames());
  std::set<JobKey> partial;
  for (const auto& [key, frame] : quarantined) partial.insert(key);
  for (const TileJournal::FrameKey& frame : parts_.journal->Frames()) {
    absl::MutexLock lock(&mutex_);
    if (!by_key_.contains(frame.first) && !partial.contains(frame.first)) parts_.journal->DropFrame(frame);
  }
  // What the last coordinator had begun to remove.
  SL_ASSIGN_OR_RETURN(const std::vector<RemovedJob> half, parts_.store->HalfRemoved());
  for (const RemovedJob& job : half) RemoveFilesSoon(job.key, job.id, 0);
  if (parts_.config.keep_jobs != absl::InfiniteDuration() || parts_.config.keep_jobs_max > 0) {
    parts_.frames_pool->Run([this] { RemoveOldJobs(); });
  }
  return AwaitWorkers();
}

absl::StatusOr<Farm::StoredProgress> Farm::ReadProgress(const JobRecord& record) {
  StoredProgress progress;
  progress.blobs = PinBlobs(record.spec);
  SL_ASSIGN_OR_RETURN(progress.quarantined, parts_.store->QuarantinedTiles(record.key));
  std::map<int, int> missing;
  for (const QuarantinedTile& tile : progress.quarantined) {
    if (!record.spec.frames.IndexOf(tile.frame)) {
      return absl::DataLossError(absl::StrCat("job ", record.id, " has no frame ", tile.frame));
    }
    ++missing[tile.frame];
  }
  SL_ASSIGN_OR_RETURN(const std::vector<FinishedFrame> finished, parts_.store->FinishedFrames(record.key));
  for (const FinishedFrame& frame : finished) {
    if (!record.spec.frames.IndexOf(frame.frame)) {
      return absl::DataLossError(absl::StrCat("job ", record.id, " has no frame ", frame.frame));
    }
    const absl::StatusOr<File> file = File::OpenToRead(FramePath(record.id, frame.frame));
    const absl::StatusOr<uint64_t> size = file.ok() ? file->Size() : absl::StatusOr<uint64_t>(file.status());
    if (size.ok() && *size == frame.size && frame.missing == missing[frame.frame]) {
      progress.finished.push_back(frame);
      continue;
    }
    spdlog::error("finished frame is missing and will be rendered again job={} frame={}", record.id,
                  frame.frame);
    SL_RETURN_IF_ERROR(parts_.store->RemoveFinishedFrame(record.key, frame.frame));
  }
  for (const std::string& id : record.wishes.after) {
    SL_ASSIGN_OR_RETURN(const JobState before, StoredState(id));
    if (before != JobState::kSucceeded) progress.waits_for.push_back(id);
  }
  return progress;
}

std::pair<Farm::JobPtr, std::vector<int>> Farm::TakeUp(const JobRecord& record,
                                                       const StoredProgress& progress) {
  const auto job = std::make_shared<LiveJob>(record, NextSeq());
  job->blobs = progress.blobs;
  jobs_[job->id()] = by_key_[job->key()] = job;
  Schedule(*job, progress.waits_for);
  JobQueue& queue = *scheduler_.Find(job->key());
  for (const QuarantinedTile& tile : progress.quarantined) {
    const int index = int(*record.spec.frames.IndexOf(tile.frame));
    if (!queue.Contains(index, tile.tile) || queue.IsQuarantined(index, tile.tile)) continue;
    queue.Quarantine(index, tile.tile);
    job->TileQuarantined(index, tile, NextSeq(), NextSeq());
  }
  for (const FinishedFrame& frame : progress.finished) {
    const int index = int(*record.spec.frames.IndexOf(frame.frame));
    if (frame.missing == 0) {
      queue.MarkFrameDone(index);
      parts_.journal->DropFrame({record.key, index});
    } else {
      // What is quarantined stays so.
      for (int tile = 0; tile < queue.tiles_per_frame(); ++tile) queue.MarkDone(index, uint32_t(tile));
    }
    job->FrameFinished(index, frame, NextSeq(), NextSeq());
  }
  std::vector<int> complete;
  for (const TileJournal::FrameKey& frame : parts_.journal->Frames()) {
    if (frame.first != record.key) continue;
    for (const uint32_t tile : parts_.journal->Tiles(frame)) {
      if (!queue.Contains(frame.second, tile) || queue.IsQuarantined(frame.second, tile)) {
        parts_.journal->Forget({frame.first, frame.second, tile});
      } else if (queue.MarkDone(frame.second, tile)) {
        // What it took went with the last coordinator: the journal holds pixels alone.
        job->TileDone(frame.second, {}, NextSeq(), NextSeq());
      }
    }
  }
  for (int index = 0; index < job->frame_count(); ++index) {
    if (job->Settled(index) && job->Frame(index).state != FrameState::kFinished) complete.push_back(index);
  }
  spdlog::info("job taken up again job={} frames_finished={} tiles_done={} tiles={}", record.id,
               job->snapshot().frames_finished, job->snapshot().tiles_done, job->snapshot().tiles_total);
  return {job, complete};
}

absl::Status Farm::ResumeJob(const JobRecord& record) {
  SL_ASSIGN_OR_RETURN(const StoredProgress progress, ReadProgress(record));
  JobPtr job;
  std::vector<int> complete;
  bool all_finished = false;
  {
    absl::MutexLock lock(&mutex_);
    const JobPtr before = FindLive(record.id);
    std::tie(job, complete) = TakeUp(record, progress);
    if (before != nullptr) job->watchers = std::move(before->watchers);
    std::erase(ended_, job->id());
    all_finished = job->AllFinished();
    Pump();
  }
  for (const int frame : complete) WriteFrameSoon(job, frame);
  // The coordinator ended between the last frame and the job's end.
  return all_finished ? EndFinishedJob(job) : absl::OkStatus();
}

}  // namespace shutterline::server
