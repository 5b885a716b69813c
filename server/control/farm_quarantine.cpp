// The part of Farm that deals with tiles that cannot be rendered.
#include <absl/strings/str_cat.h>
#include <spdlog/spdlog.h>

#include <algorithm>

#include "common/base/log.h"
#include "server/control/farm.h"

namespace shutterline::server {
namespace {

/// A job of which so many tiles are quarantined, or all, and none rendered, is hopeless.
constexpr int64_t kHopelessTiles = 3;

std::string Describe(const QuarantinedTile& tile) {
  std::string text = absl::StrCat("frame ", tile.frame, ", tile ", tile.tile);
  if (!tile.evidence.empty()) absl::StrAppend(&text, ": ", tile.evidence.back().reason);
  return text;
}

}  // namespace

void Farm::Quarantine(const std::vector<Quarantined>& tiles) {
  for (const Quarantined& tile : tiles) QuarantineOne(tile);
}

void Farm::QuarantineOne(const Quarantined& tile) {
  absl::MutexLock control_lock(&control_mutex_);
  JobPtr job;
  QuarantinedTile record{0, tile.tile, tile.evidence};
  {
    absl::MutexLock lock(&mutex_);
    const auto found = by_key_.find(tile.job);
    if (found == by_key_.end() || found->second->ending) return;
    job = found->second;
    // A retry may have released it by now.
    const JobQueue* queue = scheduler_.Find(tile.job);
    if (queue == nullptr || !queue->IsQuarantined(tile.frame, tile.tile)) return;
    record.frame = job->spec()->frames.Frame(tile.frame);
  }
  const absl::Status stored = parts_.store->Quarantine(tile.job, record);
  if (!stored.ok()) {
    spdlog::error("quarantine could not be stored, trying again job={} frame={} tile={} reason={}", job->id(),
                  record.frame, tile.tile, LogValue(stored.message()));
    absl::MutexLock lock(&mutex_);
    unstored_.push_back(tile);
    return;
  }
  spdlog::warn("tile quarantined job={} frame={} tile={} troubles={} reason={}", job->id(), record.frame,
               tile.tile, record.evidence.size(),
               LogValue(record.evidence.empty() ? "" : record.evidence.back().reason));
  bool settled = false, hopeless = false;
  {
    absl::MutexLock lock(&mutex_);
    job->TileQuarantined(tile.frame, record, NextSeq(), NextSeq());
    settled = job->Settled(tile.frame);
    const JobSnapshot& snapshot = job->snapshot();
    hopeless = snapshot.tiles_done == 0 &&
               snapshot.tiles_quarantined >= std::min(kHopelessTiles, snapshot.tiles_total);
  }
  if (hopeless) {
    (void)EndJobLocked(job, JobState::kFailed, Describe(record));  // Logged there.
  } else if (settled) {
    WriteFrameSoon(job, tile.frame);
  }
}

absl::Status Farm::EndFinishedJob(const JobPtr& job) {
  std::string error;
  {
    absl::MutexLock lock(&mutex_);
    if (!job->quarantined().empty()) {
      const int64_t tiles = job->snapshot().tiles_quarantined;
      error = absl::StrCat(tiles, tiles == 1 ? " tile is" : " tiles are",
                           " missing, the first: ", Describe(job->quarantined().begin()->second));
    }
  }
  return EndJobLocked(job, error.empty() ? JobState::kSucceeded : JobState::kPartial, error);
}

absl::StatusOr<std::vector<QuarantinedTile>> Farm::QuarantinedTiles(const std::string& job_id, size_t limit) {
  const absl::StatusOr<JobPtr> job = Find(job_id);
  if (!job.ok()) return job.status();
  std::vector<QuarantinedTile> tiles;
  absl::MutexLock lock(&mutex_);
  for (const auto& [at, tile] : (*job)->quarantined()) {
    if (tiles.size() == limit) break;
    tiles.push_back(tile);
  }
  return tiles;
}

}  // namespace shutterline::server
