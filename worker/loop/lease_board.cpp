#include "worker/loop/lease_board.h"

#include <algorithm>

#include "common/base/check.h"

namespace shutterline::worker {

bool LeaseBoard::Grant(std::shared_ptr<const WorkerJob> job, uint64_t lease_id, int frame,
                       std::span<const uint32_t> tiles) {
  bool progress = false;
  {
    absl::MutexLock lock(&mutex_);
    const auto count = uint32_t(tiles.size());
    if (tiles.empty()) {
      progress = true;  // Nothing to do: its credit is free at once.
    } else if (!leases_.try_emplace(lease_id, Lease{count, count}).second) {
      return false;
    } else {
      ++unrendered_leases_;
      for (const uint32_t tile : tiles) waiting_.push_back({job, lease_id, session_, frame, tile});
    }
  }
  if (progress && on_progress_) on_progress_();
  return true;
}

std::optional<TileTask> LeaseBoard::Take() {
  absl::MutexLock lock(&mutex_);
  mutex_.Await(absl::Condition(this, &LeaseBoard::CanTakeLocked));
  if (closed_) return std::nullopt;
  TileTask task = std::move(waiting_.front());
  waiting_.pop_front();
  ++taken_;
  return task;
}

void LeaseBoard::Rendered(const TileTask& task) {
  bool progress = false;
  {
    absl::MutexLock lock(&mutex_);
    SL_CHECK(taken_ > 0);
    --taken_;
    // A lease that was revoked meanwhile, or belongs to a session that is over, is not here any more.
    Lease* const lease = FindLocked(task);
    if (lease != nullptr && lease->unrendered > 0 && --lease->unrendered == 0) {
      --unrendered_leases_;
      progress = true;
    }
    progress |= taken_ == 0 && waiting_.empty();
  }
  if (progress && on_progress_) on_progress_();
}

void LeaseBoard::Acknowledged(const TileTask& task) {
  absl::MutexLock lock(&mutex_);
  Lease* const lease = FindLocked(task);
  if (lease == nullptr) return;
  if (lease->unacknowledged > 0) --lease->unacknowledged;
  if (lease->unacknowledged == 0 && lease->unrendered == 0) leases_.erase(task.lease_id);
}

LeaseBoard::Lease* LeaseBoard::FindLocked(const TileTask& task) {
  if (task.session != session_) return nullptr;
  const auto lease = leases_.find(task.lease_id);
  return lease == leases_.end() ? nullptr : &lease->second;
}

void LeaseBoard::Revoke(std::span<const uint64_t> lease_ids) {
  {
    absl::MutexLock lock(&mutex_);
    for (const uint64_t id : lease_ids) {
      const auto lease = leases_.find(id);
      if (lease == leases_.end()) continue;
      if (lease->second.unrendered > 0) --unrendered_leases_;
      leases_.erase(lease);
    }
    std::erase_if(waiting_, [&](const TileTask& task) {
      return std::find(lease_ids.begin(), lease_ids.end(), task.lease_id) != lease_ids.end();
    });
  }
  if (on_progress_) on_progress_();
}

void LeaseBoard::Clear() {
  absl::MutexLock lock(&mutex_);
  leases_.clear();
  waiting_.clear();
  unrendered_leases_ = 0;
  ++session_;
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
  ids.reserve(leases_.size());
  for (const auto& [id, lease] : leases_) ids.push_back(id);
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

}  // namespace shutterline::worker
