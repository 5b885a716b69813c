#include "worker/loop/lease_board.h"

#include <algorithm>
#include <iterator>

#include "common/base/check.h"

namespace shutterline::worker {
namespace {

/// Frames that are known to be ready: about as many as are kept. One that is not kept any more is made ready
/// again by the first thread that asks for it, for which the others wait.
constexpr size_t kReadyFrames = 4;

}  // namespace

bool LeaseBoard::Grant(std::shared_ptr<const WorkerJob> job, uint64_t lease_id, int frame,
                       std::span<const uint32_t> tiles, bool send_at_once) {
  bool progress = false;
  {
    absl::MutexLock lock(&mutex_);
    if (tiles.empty()) {
      progress = true;  // Nothing to do: its credit is free at once.
    } else if (!tickets_.try_emplace(lease_id, next_ticket_).second) {
      return false;
    } else {
      const uint64_t ticket = next_ticket_++;
      Lease& lease = leases_[ticket];
      lease.job = job;
      lease.frame = frame;
      lease.lease_id = lease_id;
      lease.unrendered = tiles.size();
      for (const uint32_t tile : tiles) {
        lease.tiles.push_back({tile, false});
        waiting_.push_back({job, ticket, lease_id, session_, frame, tile, send_at_once});
      }
      ++unrendered_leases_;
    }
  }
  if (progress && on_progress_) on_progress_();
  return true;
}

std::optional<TileTask> LeaseBoard::Take() {
  absl::MutexLock lock(&mutex_);
  ++idle_;
  mutex_.Await(absl::Condition(this, &LeaseBoard::CanTakeLocked));
  --idle_;
  if (closed_) return std::nullopt;
  const auto next = NextLocked();
  TileTask task = *next;
  waiting_.erase(next);
  FrameName frame(task.job, task.frame);
  if (std::find(ready_.begin(), ready_.end(), frame) == ready_.end()) preparing_.push_back(std::move(frame));
  ++taken_;
  return task;
}

bool LeaseBoard::CanStartLocked(const TileTask& task) const {
  return std::none_of(preparing_.begin(), preparing_.end(), [&](const FrameName& frame) {
    const WorkerJob& job = *frame.first;
    if (&job == task.job.get() && frame.second == task.frame) return true;
    return job.scene_key == task.job->scene_key && !job.imported && !task.job->imported;
  });
}

std::deque<TileTask>::const_iterator LeaseBoard::NextLocked() const {
  return std::find_if(waiting_.begin(), waiting_.end(),
                      [this](const TileTask& task) ABSL_NO_THREAD_SAFETY_ANALYSIS {
                        return task.job->forgotten || CanStartLocked(task);
                      });
}

void LeaseBoard::FrameReady(const TileTask& task, bool ok) {
  const FrameName frame(task.job, task.frame);
  if (ok && !task.job->imported) task.job->imported = true;
  absl::MutexLock lock(&mutex_);
  const auto preparing = std::find(preparing_.begin(), preparing_.end(), frame);
  if (preparing == preparing_.end()) return;  // It was ready before.
  preparing_.erase(preparing);
  if (!ok) return;
  ready_.push_front(frame);
  if (ready_.size() > kReadyFrames) ready_.pop_back();
}

bool LeaseBoard::Rendered(const TileTask& task) {
  bool progress = false, frame_left = false;
  {
    absl::MutexLock lock(&mutex_);
    SL_CHECK(taken_ > 0);
    --taken_;
    // The lease may have been revoked meanwhile, or the tile not been adopted with it.
    const auto lease = leases_.find(task.ticket);
    if (lease != leases_.end()) {
      std::vector<Tile>& tiles = lease->second.tiles;
      const auto tile = std::find_if(tiles.begin(), tiles.end(),
                                     [&](const Tile& t) { return t.tile == task.tile && !t.rendered; });
      if (tile != tiles.end()) {
        tile->rendered = true;
        if (--lease->second.unrendered == 0) {
          --unrendered_leases_;
          progress = true;
        }
      }
    }
    progress |= taken_ == 0 && waiting_.empty();
    frame_left = std::none_of(leases_.begin(), leases_.end(), [&](const auto& entry) {
      const Lease& other = entry.second;
      return other.unrendered > 0 && other.frame == task.frame && other.job == task.job;
    });
  }
  if (progress && on_progress_) on_progress_();
  return frame_left;
}

void LeaseBoard::Acknowledged(const TileTask& task) {
  absl::MutexLock lock(&mutex_);
  const auto lease = leases_.find(task.ticket);
  if (lease == leases_.end()) return;
  std::vector<Tile>& tiles = lease->second.tiles;
  const auto tile = std::find_if(tiles.begin(), tiles.end(),
                                 [&](const Tile& t) { return t.tile == task.tile && t.rendered; });
  if (tile != tiles.end()) tiles.erase(tile);
  if (tiles.empty()) EraseLocked(lease);
}

void LeaseBoard::EraseLocked(Leases::iterator lease) {
  if (lease->second.unrendered > 0) --unrendered_leases_;
  if (lease->second.lease_id) tickets_.erase(*lease->second.lease_id);
  leases_.erase(lease);
}

void LeaseBoard::DropWaitingLocked() {
  std::erase_if(waiting_, [this](const TileTask& task) ABSL_NO_THREAD_SAFETY_ANALYSIS {
    const auto lease = leases_.find(task.ticket);
    if (lease == leases_.end()) return true;
    return std::none_of(lease->second.tiles.begin(), lease->second.tiles.end(),
                        [&](const Tile& t) { return t.tile == task.tile && !t.rendered; });
  });
}

void LeaseBoard::Revoke(std::span<const uint64_t> lease_ids) {
  {
    absl::MutexLock lock(&mutex_);
    for (const uint64_t id : lease_ids) {
      const auto ticket = tickets_.find(id);
      if (ticket != tickets_.end()) EraseLocked(leases_.find(ticket->second));
    }
    DropWaitingLocked();
  }
  if (on_progress_) on_progress_();
}

void LeaseBoard::RevokeTiles(uint64_t lease_id, std::span<const uint32_t> tiles) {
  {
    absl::MutexLock lock(&mutex_);
    const auto ticket = tickets_.find(lease_id);
    if (ticket == tickets_.end()) return;
    const auto found = leases_.find(ticket->second);
    KeepLocked(found, [&](const Tile& tile) {
      return tile.rendered || std::find(tiles.begin(), tiles.end(), tile.tile) == tiles.end();
    });
    DropWaitingLocked();
  }
  if (on_progress_) on_progress_();
}

void LeaseBoard::KeepLocked(Leases::iterator found, absl::FunctionRef<bool(const Tile&)> keeps) {
  Lease& lease = found->second;
  const bool was_unrendered = lease.unrendered > 0;
  std::erase_if(lease.tiles, [&](const Tile& tile) { return !keeps(tile); });
  lease.unrendered = size_t(
      std::count_if(lease.tiles.begin(), lease.tiles.end(), [](const Tile& tile) { return !tile.rendered; }));
  if (was_unrendered && lease.unrendered == 0) --unrendered_leases_;
  if (lease.tiles.empty()) EraseLocked(found);
}

void LeaseBoard::Suspend() {
  absl::MutexLock lock(&mutex_);
  for (auto& [ticket, lease] : leases_) lease.lease_id.reset();
  tickets_.clear();
  ++session_;
}

std::vector<LeaseBoard::Held> LeaseBoard::Suspended() const {
  absl::MutexLock lock(&mutex_);
  std::vector<Held> held;
  for (const auto& [ticket, lease] : leases_) {
    if (lease.lease_id) continue;
    Held& one = held.emplace_back(Held{ticket, lease.job, lease.frame, {}});
    for (const Tile& tile : lease.tiles) one.tiles.push_back(tile.tile);
  }
  return held;
}

bool LeaseBoard::Adopt(uint64_t ticket, uint64_t lease_id, std::span<const uint32_t> tiles) {
  {
    absl::MutexLock lock(&mutex_);
    const auto found = leases_.find(ticket);
    if (found == leases_.end() || found->second.lease_id) return false;
    if (!tickets_.try_emplace(lease_id, ticket).second) return false;
    found->second.lease_id = lease_id;
    KeepLocked(found, [&](const Tile& tile) {
      return std::find(tiles.begin(), tiles.end(), tile.tile) != tiles.end();
    });
    DropWaitingLocked();
  }
  if (on_progress_) on_progress_();
  return true;
}

void LeaseBoard::DropSuspended() {
  {
    absl::MutexLock lock(&mutex_);
    for (auto lease = leases_.begin(); lease != leases_.end();) {
      const auto next = std::next(lease);
      const uint64_t next_ticket = next == leases_.end() ? 0 : next->first;
      if (!lease->second.lease_id) EraseLocked(lease);
      lease = next_ticket == 0 ? leases_.end() : leases_.find(next_ticket);
    }
    DropWaitingLocked();
  }
  if (on_progress_) on_progress_();
}

uint64_t LeaseBoard::session() const {
  absl::MutexLock lock(&mutex_);
  return session_;
}

void LeaseBoard::Close() {
  absl::MutexLock lock(&mutex_);
  closed_ = true;
}

std::vector<uint64_t> LeaseBoard::LiveLeases() const {
  absl::MutexLock lock(&mutex_);
  std::vector<uint64_t> ids;
  ids.reserve(tickets_.size());
  for (const auto& [id, ticket] : tickets_) ids.push_back(id);
  return ids;
}

size_t LeaseBoard::UnrenderedLeases() const {
  absl::MutexLock lock(&mutex_);
  return unrendered_leases_;
}

bool LeaseBoard::Idle() const {
  absl::MutexLock lock(&mutex_);
  return waiting_.empty() && taken_ == 0;
}

bool LeaseBoard::Starved() const {
  absl::MutexLock lock(&mutex_);
  return idle_ > 0 && !waiting_.empty() && !CanTakeLocked();
}

}  // namespace shutterline::worker
