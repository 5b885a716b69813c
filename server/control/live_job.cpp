#include "server/control/live_job.h"

namespace shutterline::server {

LiveJob::LiveJob(const JobRecord& record, uint64_t seq) : frames_(size_t(record.spec.frames.Count())) {
  snapshot_.key = record.key;
  snapshot_.id = record.id;
  snapshot_.spec = std::make_shared<const JobSpec>(record.spec);
  snapshot_.state = record.state;
  snapshot_.error = record.error;
  snapshot_.frames_total = record.spec.frames.Count();
  snapshot_.tiles_total = snapshot_.frames_total * grid().Count();
  snapshot_.submitted = record.submitted;
  snapshot_.ended = record.ended;
  snapshot_.paused = record.paused;
  snapshot_.wishes = record.wishes;
  Changed(seq_, seq, kJobItself);
}

void LiveJob::Changed(uint64_t& last, uint64_t seq, int what) {
  changes_.erase(last);
  changes_[seq] = what;
  last = seq;
  dirty = true;
}

FrameSnapshot LiveJob::Frame(int index) const {
  const FrameProgress& frame = frames_[size_t(index)];
  FrameSnapshot snapshot;
  snapshot.frame = spec()->frames.Frame(index);
  snapshot.state = frame.finished         ? FrameState::kFinished
                   : frame.tiles_done > 0 ? FrameState::kRunning
                                          : FrameState::kQueued;
  snapshot.tiles_total = grid().Count();
  snapshot.tiles_done = frame.tiles_done;
  snapshot.digest = frame.digest;
  snapshot.size = frame.size;
  snapshot.stats = frame.stats;
  snapshot.tiles_missing = frame.missing;
  return snapshot;
}

bool LiveJob::Settled(int index) const {
  const FrameProgress& frame = frames_[size_t(index)];
  return frame.tiles_done + frame.missing == grid().Count();
}

std::set<uint32_t> LiveJob::Missing(int index) const {
  std::set<uint32_t> tiles;
  for (auto tile = quarantined_.lower_bound({index, 0}); tile != quarantined_.end(); ++tile) {
    if (tile->first.first != index) break;
    tiles.insert(tile->first.second);
  }
  return tiles;
}

void LiveJob::TileDone(int index, const RenderStats& stats, uint64_t seq, uint64_t frame_seq) {
  ++frames_[size_t(index)].tiles_done;
  frames_[size_t(index)].stats += stats;
  ++snapshot_.tiles_done;
  if (snapshot_.state == JobState::kQueued) snapshot_.state = JobState::kRunning;
  Changed(frames_[size_t(index)].seq, frame_seq, index);
  Changed(seq_, seq, kJobItself);
}

void LiveJob::TilesLost(int index, int count, uint64_t seq, uint64_t frame_seq) {
  frames_[size_t(index)].tiles_done -= count;
  snapshot_.tiles_done -= count;
  Changed(frames_[size_t(index)].seq, frame_seq, index);
  Changed(seq_, seq, kJobItself);
}

void LiveJob::FrameFinished(int index, const FinishedFrame& finished, uint64_t seq, uint64_t frame_seq) {
  FrameProgress& frame = frames_[size_t(index)];
  const int done = grid().Count() - finished.missing;
  snapshot_.tiles_done += done - frame.tiles_done;
  frame.tiles_done = done;
  frame.finished = true;
  frame.digest = finished.digest;
  frame.size = finished.size;
  frame.stats = finished.stats;
  ++snapshot_.frames_finished;
  if (snapshot_.state == JobState::kQueued) snapshot_.state = JobState::kRunning;
  Changed(frame.seq, frame_seq, index);
  Changed(seq_, seq, kJobItself);
}

void LiveJob::CountMismatch(uint64_t seq) {
  ++snapshot_.mismatched_tiles;
  Changed(seq_, seq, kJobItself);
}

void LiveJob::TileQuarantined(int index, const QuarantinedTile& tile, uint64_t seq, uint64_t frame_seq) {
  if (!quarantined_.insert_or_assign({index, tile.tile}, tile).second) return;
  FrameProgress& frame = frames_[size_t(index)];
  ++frame.missing;
  ++snapshot_.tiles_quarantined;
  if (snapshot_.state == JobState::kQueued) snapshot_.state = JobState::kRunning;
  Changed(frame.seq, frame_seq, index);
  Changed(seq_, seq, kJobItself);
}

std::vector<std::pair<int, uint32_t>> LiveJob::Testify(const std::string& worker_uuid,
                                                       const ProcessEnd& end) {
  std::vector<std::pair<int, uint32_t>> told;
  for (auto& [at, tile] : quarantined_) {
    bool news = false;
    for (TileTrouble& trouble : tile.evidence) news |= end.AddTo(worker_uuid, trouble);
    if (news) told.push_back(at);
  }
  return told;
}

void LiveJob::ReleaseQuarantined(absl::FunctionRef<uint64_t()> next_seq) {
  quarantined_.clear();
  snapshot_.tiles_quarantined = 0;
  for (int index = 0; index < frame_count(); ++index) {
    FrameProgress& frame = frames_[size_t(index)];
    if (frame.missing == 0) continue;
    frame.missing = 0;
    if (frame.finished) --snapshot_.frames_finished;
    frame.finished = false;
    Changed(frame.seq, next_seq(), index);
  }
  Changed(seq_, next_seq(), kJobItself);
}

void LiveJob::SetPaused(bool paused, uint64_t seq) {
  snapshot_.paused = paused;
  Changed(seq_, seq, kJobItself);
}

void LiveJob::SetPriority(int priority, uint64_t seq) {
  snapshot_.wishes.priority = priority;
  Changed(seq_, seq, kJobItself);
}

void LiveJob::WaitFor(const std::string& job_id, uint64_t seq) {
  snapshot_.waits_for.insert(job_id);
  Changed(seq_, seq, kJobItself);
}

bool LiveJob::WaitsNoMoreFor(const std::string& job_id, uint64_t seq) {
  if (snapshot_.waits_for.erase(job_id) == 0) return false;
  Changed(seq_, seq, kJobItself);
  return true;
}

void LiveJob::End(JobState state, const std::string& error, absl::Time now, uint64_t seq) {
  snapshot_.state = state;
  snapshot_.error = error;
  snapshot_.ended = now;
  blobs.reset();
  Changed(seq_, seq, kJobItself);
}

std::optional<JobChange> LiveJob::NextChange(uint64_t seq) const {
  const auto next = changes_.upper_bound(seq);
  if (next == changes_.end()) return std::nullopt;
  if (next->second == kJobItself) return JobChange{next->first, snapshot_};
  return JobChange{next->first, Frame(next->second)};
}

}  // namespace shutterline::server
