#include "server/schedule/job_queue.h"

#include <algorithm>

#include "common/base/check.h"
#include "server/schedule/tile_order.h"

namespace shutterline::server {
namespace {

/// Of a tile: what is older is left out.
constexpr size_t kMaxEvidence = 16;

}  // namespace

JobQueue::JobQueue(int frames, int columns, int rows, TileOrder order)
    : order_(OrderTiles(order, columns, rows)), frames_(size_t(frames)) {
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

bool JobQueue::IsQuarantined(int frame, uint32_t tile) const {
  const Frame* active = Active(frame);
  return active != nullptr && active->quarantined.contains(tile);
}

int JobQueue::DoneInFrame(int frame) const {
  const Slot& slot = frames_[size_t(frame)];
  if (slot.phase == Phase::kDone) return tiles_per_frame();
  return slot.frame == nullptr ? 0 : slot.frame->done_count;
}

Holders JobQueue::HoldersOf(int frame, uint32_t tile) const {
  const Frame* active = Active(frame);
  if (active == nullptr) return {};
  const auto found = active->leased.find(tile);
  return found == active->leased.end() ? Holders{} : found->second;
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

void JobQueue::Unqueue(int frame, Frame& f) {
  --f.queued;
  --queued_;
  if (f.queued == 0) hungry_.erase(frame);
}

void JobQueue::Requeue(int frame, Frame& f, uint32_t tile, bool first) {
  if (first) {
    f.returned.push_front(tile);
  } else {
    f.returned.push_back(tile);
  }
  ++f.queued;
  ++queued_;
  hungry_.insert(frame);
}

bool JobQueue::MarkDone(int frame, uint32_t tile) {
  if (IsDone(frame, tile) || IsQuarantined(frame, tile)) return false;
  Frame& f = Touch(frame);
  f.done[tile] = true;
  ++f.done_count;
  --remaining_;
  f.troubles.erase(tile);
  if (f.leased.erase(tile) == 0) Unqueue(frame, f);
  if (f.done_count == tiles_per_frame()) Finish(frame);
  return true;
}

void JobQueue::MarkFrameDone(int frame) {
  if (frames_[size_t(frame)].phase == Phase::kDone) return;
  const Frame& f = Touch(frame);
  remaining_ -= tiles_per_frame() - f.done_count - int64_t(f.quarantined.size());
  quarantined_ -= int64_t(f.quarantined.size());
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
    ++remaining_;
    Requeue(frame, f, tile, false);
  }
}

void JobQueue::Quarantine(int frame, uint32_t tile) {
  Frame& f = Touch(frame);
  SL_CHECK(f.IsQueued(tile));
  f.quarantined.insert(tile);
  ++quarantined_;
  --remaining_;
  Unqueue(frame, f);
}

std::vector<std::pair<int, uint32_t>> JobQueue::Release() {
  std::vector<std::pair<int, uint32_t>> released;
  for (int frame = 0; quarantined_ > 0 && frame < frame_count(); ++frame) {
    Frame* f = Active(frame);
    if (f == nullptr) continue;
    for (const uint32_t tile : std::exchange(f->quarantined, {})) {
      f->troubles.erase(tile);
      --quarantined_;
      ++remaining_;
      Requeue(frame, *f, tile, true);
      released.emplace_back(frame, tile);
    }
  }
  return released;
}

bool JobQueue::Offers(const Frame& f, Refuses refuses) const {
  int refused = 0;
  for (const auto& [tile, log] : f.troubles) {
    if (f.IsQueued(tile) && refuses(log)) ++refused;
  }
  return f.queued > refused;
}

std::optional<int> JobQueue::ChooseFrame(const std::deque<int>& held, WorkerId worker,
                                         Refuses refuses) const {
  for (const int frame : held) {
    if (hungry_.contains(frame) && Offers(*Active(frame), refuses)) return frame;
  }
  // Frames that are under way but left by all their workers come before new ones.
  for (const int frame : hungry_) {
    if (Active(frame)->workers.empty() && Offers(*Active(frame), refuses)) return frame;
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
    if ((!best || share > most) && Offers(f, refuses)) {
      best = frame;
      most = share;
    }
  }
  return best;
}

JobQueue::Taken JobQueue::Take(int frame, int count, WorkerId worker, LeaseId lease, Refuses refuses) {
  Frame& f = Touch(frame);
  Taken result;
  std::vector<uint32_t>& taken = result.tiles;
  std::vector<uint32_t> left;  // Of those that came back: not for this worker, or not in company.
  bool alone = false;
  const auto take = [&](uint32_t tile) {
    const auto troubles = f.troubles.find(tile);
    if (troubles != f.troubles.end()) {
      // A tile that workers died of must not take others with it.
      if (refuses(troubles->second) || (troubles->second.suspect() && !taken.empty())) return false;
      alone = troubles->second.suspect();
    }
    taken.push_back(tile);
    f.leased[tile].first = lease;
    --f.queued;
    --queued_;
    return true;
  };
  while (int(taken.size()) < count && !alone && !f.returned.empty()) {
    const uint32_t tile = f.returned.front();
    f.returned.pop_front();
    if (f.IsQueued(tile) && !take(tile)) left.push_back(tile);
  }
  result.came_back = !taken.empty();
  while (int(taken.size()) < count && !alone && f.cursor < order_.size()) {
    const uint32_t tile = order_[f.cursor++];
    if (f.IsQueued(tile) && !take(tile)) left.push_back(tile);
  }
  f.returned.insert(f.returned.begin(), left.begin(), left.end());
  if (!taken.empty()) f.workers.insert(worker);
  if (f.queued == 0) hungry_.erase(frame);
  return result;
}

std::vector<uint32_t> JobQueue::TakeThese(int frame, const std::vector<uint32_t>& tiles, WorkerId worker,
                                          LeaseId lease) {
  std::vector<uint32_t> taken;
  if (frames_[size_t(frame)].phase == Phase::kDone) return taken;
  Frame& f = Touch(frame);
  for (const uint32_t tile : tiles) {
    const auto troubles = f.troubles.find(tile);
    if (!f.IsQueued(tile) || (troubles != f.troubles.end() && troubles->second.suspect())) continue;
    taken.push_back(tile);
    f.leased[tile].first = lease;
    Unqueue(frame, f);
  }
  if (!taken.empty()) f.workers.insert(worker);
  return taken;
}

void JobQueue::AddCopy(int frame, uint32_t tile, WorkerId worker, LeaseId lease) {
  Frame& f = Touch(frame);
  Holders& holders = f.leased.at(tile);
  SL_CHECK(holders.first != 0 && holders.second == 0);
  holders.second = lease;
  f.workers.insert(worker);
}

void JobQueue::PutBack(int frame, uint32_t tile, LeaseId lease) {
  Frame* f = Active(frame);
  if (f == nullptr) return;
  const auto found = f->leased.find(tile);
  if (found == f->leased.end() || !found->second.Has(lease)) return;
  Holders& holders = found->second;
  if (holders.first == lease) holders.first = holders.second;
  holders.second = 0;
  if (holders.first != 0) return;
  f->leased.erase(found);
  // A tile that has made trouble comes first: its job's fate is known the sooner.
  Requeue(frame, *f, tile, f->troubles.contains(tile));
}

void JobQueue::Leave(int frame, WorkerId worker) {
  if (Frame* f = Active(frame)) f->workers.erase(worker);
}

const TroubleLog* JobQueue::TroublesOf(int frame, uint32_t tile) const {
  const Frame* f = Active(frame);
  if (f == nullptr) return nullptr;
  const auto found = f->troubles.find(tile);
  return found == f->troubles.end() ? nullptr : &found->second;
}

const TroubleLog& JobQueue::AddTrouble(int frame, uint32_t tile, TileTrouble trouble) {
  TroubleLog& log = Touch(frame).troubles[tile];
  ++(trouble.worker_ended ? log.deaths : log.failures);
  log.failed_by.insert(trouble.worker_uuid);
  if (trouble.worker_ended) log.dead[trouble.worker_uuid] = trouble.boot_id;
  if (log.evidence.size() == kMaxEvidence) log.evidence.erase(log.evidence.begin());
  log.evidence.push_back(std::move(trouble));
  return log;
}

void JobQueue::Acquit(const std::string& worker_uuid, const std::string& boot_id) {
  for (const Slot& slot : frames_) {
    if (slot.frame == nullptr) continue;
    for (auto& [tile, log] : slot.frame->troubles) Acquit(log, worker_uuid, boot_id);
  }
}

void JobQueue::Acquit(TroubleLog& log, const std::string& worker_uuid, const std::string& boot_id) {
  const auto dead = log.dead.find(worker_uuid);
  if (dead == log.dead.end() || dead->second != boot_id) return;
  log.dead.erase(dead);
  log.failed_by.erase(worker_uuid);
  --log.deaths;
  // The latest of it: earlier ones may be of an earlier process.
  const auto of_it = std::find_if(log.evidence.rbegin(), log.evidence.rend(), [&](const TileTrouble& t) {
    return t.worker_ended && t.worker_uuid == worker_uuid;
  });
  if (of_it != log.evidence.rend()) log.evidence.erase(std::next(of_it).base());
}

bool JobQueue::Blames(int frame, uint32_t tile, const std::string& worker_uuid,
                      const std::string& boot_id) const {
  const TroubleLog* log = TroublesOf(frame, tile);
  if (log == nullptr) return false;
  const auto dead = log->dead.find(worker_uuid);
  return dead != log->dead.end() && dead->second == boot_id;
}

void JobQueue::Testify(const std::string& worker_uuid, const ProcessEnd& end,
                       absl::FunctionRef<bool(int frame, uint32_t tile)> acquits) {
  for (int frame = 0; frame < frame_count(); ++frame) {
    Frame* f = Active(frame);
    if (f == nullptr) continue;
    for (auto& [tile, log] : f->troubles) {
      for (TileTrouble& trouble : log.evidence) end.AddTo(worker_uuid, trouble);
      if (!f->quarantined.contains(tile) && acquits(frame, tile)) Acquit(log, worker_uuid, end.boot_id);
    }
  }
}

}  // namespace shutterline::server
