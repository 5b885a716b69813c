#include "server/schedule/job_queue.h"

#include <algorithm>

#include "common/base/check.h"
#include "server/schedule/tile_order.h"

namespace shutterline::server {

JobQueue::JobQueue(int frames, int columns, int rows)
    : order_(HilbertOrder(columns, rows)), frames_(size_t(frames)) {
  queued_ = remaining_ = int64_t{frames} * int64_t(order_.size());
}

bool JobQueue::Contains(int frame, uint32_t tile) const {
  return frame >= 0 && frame < frame_count() && tile < order_.size();
}

JobQueue::Frame* JobQueue::Active(int frame) const {
  return frames_[size_t(frame)].frame.get();
}

bool JobQueue::IsDone(int frame, uint32_t tile) const {
  const Slot& slot = frames_[size_t(frame)];
  return slot.phase == Phase::kDone || (slot.phase == Phase::kActive && slot.frame->done[tile]);
}

int JobQueue::DoneInFrame(int frame) const {
  const Slot& slot = frames_[size_t(frame)];
  if (slot.phase == Phase::kDone) return tiles_per_frame();
  return slot.frame == nullptr ? 0 : slot.frame->done_count;
}

LeaseId JobQueue::Holder(int frame, uint32_t tile) const {
  const Frame* active = Active(frame);
  if (active == nullptr) return 0;
  const auto found = active->leased.find(tile);
  return found == active->leased.end() ? 0 : found->second;
}

JobQueue::Frame& JobQueue::Touch(int frame) {
  Slot& slot = frames_[size_t(frame)];
  SL_CHECK(slot.phase != Phase::kDone);
  if (slot.phase == Phase::kUntouched) {
    slot.phase = Phase::kActive;
    slot.frame = std::make_unique<Frame>();
    slot.frame->done.resize(order_.size());
    slot.frame->queued = tiles_per_frame();
    hungry_.insert(frame);
  }
  return *slot.frame;
}

void JobQueue::Finish(int frame) {
  Slot& slot = frames_[size_t(frame)];
  slot.phase = Phase::kDone;
  slot.frame.reset();
  hungry_.erase(frame);
}

bool JobQueue::MarkDone(int frame, uint32_t tile) {
  if (IsDone(frame, tile)) return false;
  Frame& f = Touch(frame);
  f.done[tile] = true;
  ++f.done_count;
  --remaining_;
  f.trouble.erase(tile);
  if (f.leased.erase(tile) == 0) {
    --f.queued;
    --queued_;
    if (f.queued == 0) hungry_.erase(frame);
  }
  if (f.done_count == tiles_per_frame()) Finish(frame);
  return true;
}

void JobQueue::MarkFrameDone(int frame) {
  if (frames_[size_t(frame)].phase == Phase::kDone) return;
  const Frame& f = Touch(frame);
  remaining_ -= tiles_per_frame() - f.done_count;
  queued_ -= f.queued;
  Finish(frame);
}

void JobQueue::Reopen(int frame, const std::vector<uint32_t>& tiles) {
  Slot& slot = frames_[size_t(frame)];
  if (slot.phase == Phase::kDone) {
    slot.phase = Phase::kActive;
    slot.frame = std::make_unique<Frame>();
    slot.frame->done.assign(order_.size(), true);
    slot.frame->done_count = tiles_per_frame();
    slot.frame->cursor = order_.size();
  }
  Frame& f = Touch(frame);
  for (const uint32_t tile : tiles) {
    if (!f.done[tile]) continue;
    f.done[tile] = false;
    --f.done_count;
    f.returned.push_back(tile);
    ++f.queued;
    ++queued_;
    ++remaining_;
    hungry_.insert(frame);
  }
}

std::optional<int> JobQueue::ChooseFrame(const std::deque<int>& held, WorkerId worker) const {
  for (const int frame : held) {
    if (hungry_.contains(frame)) return frame;
  }
  // Frames that are under way but left by all their workers come before new ones.
  for (const int frame : hungry_) {
    if (Active(frame)->workers.empty()) return frame;
  }
  while (first_untouched_ < frame_count() && frames_[size_t(first_untouched_)].phase != Phase::kUntouched) {
    ++first_untouched_;
  }
  if (first_untouched_ < frame_count()) return first_untouched_;
  std::optional<int> best;
  double most = 0;
  for (const int frame : hungry_) {
    const Frame& f = *Active(frame);
    const double share = f.queued / (1.0 + double(f.workers.size()) - (f.workers.contains(worker) ? 1 : 0));
    if (!best || share > most) {
      best = frame;
      most = share;
    }
  }
  return best;
}

std::vector<uint32_t> JobQueue::Take(int frame, int count, WorkerId worker, LeaseId lease) {
  Frame& f = Touch(frame);
  std::vector<uint32_t> taken;
  bool alone = false;
  const auto take = [&](uint32_t tile) {
    // A tile that workers died of must not take others with it.
    const auto trouble = f.trouble.find(tile);
    alone = trouble != f.trouble.end() && !trouble->second.dead_workers.empty();
    if (alone && !taken.empty()) return false;
    taken.push_back(tile);
    f.leased[tile] = lease;
    --f.queued;
    --queued_;
    return true;
  };
  while (int(taken.size()) < count && !alone && !f.returned.empty()) {
    const uint32_t tile = f.returned.front();
    if (!f.done[tile] && !f.leased.contains(tile) && !take(tile)) break;
    f.returned.pop_front();
  }
  while (int(taken.size()) < count && !alone && f.cursor < order_.size()) {
    const uint32_t tile = order_[f.cursor];
    if (!f.done[tile] && !f.leased.contains(tile)) take(tile);
    ++f.cursor;
  }
  if (!taken.empty()) f.workers.insert(worker);
  if (f.queued == 0) hungry_.erase(frame);
  return taken;
}

void JobQueue::PutBack(int frame, uint32_t tile, LeaseId lease) {
  Frame* f = Active(frame);
  if (f == nullptr) return;
  const auto found = f->leased.find(tile);
  if (found == f->leased.end() || found->second != lease) return;
  f->leased.erase(found);
  // A tile that has made trouble comes first: its job's fate is known the sooner.
  if (f->trouble.contains(tile)) {
    f->returned.push_front(tile);
  } else {
    f->returned.push_back(tile);
  }
  ++f->queued;
  ++queued_;
  hungry_.insert(frame);
}

void JobQueue::Leave(int frame, WorkerId worker) {
  if (Frame* f = Active(frame)) f->workers.erase(worker);
}

int JobQueue::CountFailure(int frame, uint32_t tile) {
  return IsDone(frame, tile) ? 0 : ++Touch(frame).trouble[tile].failures;
}

int JobQueue::CountDeath(int frame, uint32_t tile, const std::string& worker_uuid) {
  if (IsDone(frame, tile)) return 0;
  Trouble& trouble = Touch(frame).trouble[tile];
  trouble.dead_workers.insert(worker_uuid);
  return int(trouble.dead_workers.size());
}

}  // namespace shutterline::server
