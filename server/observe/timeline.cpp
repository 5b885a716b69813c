#include "server/observe/timeline.h"

#include <algorithm>
#include <limits>

namespace shutterline::server {

Timeline::Frame& Timeline::Touch(const Key& key) {
  const auto [found, is_new] = frames_.try_emplace(key);
  if (is_new) {
    found->second.timeline.id = next_id_++;
    begun_.push_back(key);
  }
  return found->second;
}

bool Timeline::MakeRoom(const Key& key) {
  while (entries_ >= max_entries_) {
    if (begun_.empty() || begun_.front() == key) return false;
    const auto oldest = frames_.find(begun_.front());
    entries_ -= oldest->second.timeline.tiles.size() + oldest->second.open.size();
    frames_.erase(oldest);
    begun_.pop_front();
  }
  return true;
}

void Timeline::CloseGrants(Frame& frame) {
  entries_ -= frame.open.size();
  frame.open = {};
}

uint32_t Timeline::WorkerIndex(Frame& frame, WorkerId worker, absl::string_view uuid,
                               absl::string_view name) {
  const auto [found, is_new] = frame.workers.emplace(worker, uint32_t(frame.timeline.workers.size()));
  if (is_new) frame.timeline.workers.push_back({std::string(uuid), std::string(name)});
  return found->second;
}

void Timeline::OnGranted(const Granted& seen) {
  absl::MutexLock lock(&mutex_);
  const Key key(seen.job_id, seen.frame);
  Frame& frame = Touch(key);
  WorkerIndex(frame, seen.worker, seen.worker_uuid, seen.worker_name);
  for (const uint32_t tile : seen.tiles) {
    const auto before = frame.open.find({tile, seen.worker});
    if (before != frame.open.end()) {
      before->second = {seen.lease, seen.at};
    } else if (MakeRoom(key)) {
      frame.open.emplace(std::make_pair(tile, seen.worker), Grant{seen.lease, seen.at});
      ++entries_;
    }
  }
}

void Timeline::OnTileStored(const TileStored& seen) {
  absl::MutexLock lock(&mutex_);
  const Key key(seen.job_id, seen.frame);
  Frame& frame = Touch(key);
  FrameTimeline::Tile tile;
  tile.tile = seen.tile;
  tile.worker = WorkerIndex(frame, seen.worker, "", "");
  tile.received = seen.received;
  tile.durable = seen.durable;
  tile.render_time = std::max(absl::ZeroDuration(), seen.render_time);
  tile.granted = seen.received - tile.render_time;
  const auto grant = frame.open.find({seen.tile, seen.worker});
  if (grant != frame.open.end()) {
    tile.lease = grant->second.lease;
    tile.granted = grant->second.at;
    frame.open.erase(grant);
    --entries_;
  }
  if (!MakeRoom(key)) return;
  frame.timeline.tiles.push_back(tile);
  ++entries_;
}

void Timeline::OnFrameWritten(const FrameWritten& seen) {
  absl::MutexLock lock(&mutex_);
  const auto found = frames_.find({std::string(seen.job_id), seen.frame});
  if (found == frames_.end()) return;
  found->second.timeline.assembly = {seen.began, seen.ended};
  CloseGrants(found->second);
}

void Timeline::OnJobEnded(absl::string_view job_id, JobState) {
  absl::MutexLock lock(&mutex_);
  for (auto at = frames_.lower_bound({std::string(job_id), std::numeric_limits<int>::min()});
       at != frames_.end() && at->first.first == job_id; ++at) {
    CloseGrants(at->second);
  }
}

std::vector<int> Timeline::Frames(const std::string& job_id) const {
  absl::MutexLock lock(&mutex_);
  std::vector<int> frames;
  for (auto at = frames_.lower_bound({job_id, std::numeric_limits<int>::min()});
       at != frames_.end() && at->first.first == job_id; ++at) {
    frames.push_back(at->first.second);
  }
  return frames;
}

std::optional<FrameTimeline> Timeline::Find(const std::string& job_id, int frame, size_t skip) const {
  absl::MutexLock lock(&mutex_);
  const auto found = frames_.find({job_id, frame});
  if (found == frames_.end()) return std::nullopt;
  const FrameTimeline& whole = found->second.timeline;
  FrameTimeline result;
  result.id = whole.id;
  result.workers = whole.workers;
  result.skipped = std::min(skip, whole.tiles.size());
  result.tiles.assign(whole.tiles.begin() + std::ptrdiff_t(result.skipped), whole.tiles.end());
  result.assembly = whole.assembly;
  return result;
}

size_t Timeline::entries() const {
  absl::MutexLock lock(&mutex_);
  return entries_;
}

}  // namespace shutterline::server
