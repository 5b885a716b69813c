// The part of Farm that lets workers go on with what they were at before their session ended, or the
// coordinator.
#include <spdlog/spdlog.h>

#include <algorithm>

#include "common/base/status_macros.h"
#include "server/control/farm.h"

namespace shutterline::server {

void Farm::Adopt(WorkerEntry& worker, const std::vector<HeldLease>& held) {
  // What the process held under an earlier registration is free: it says itself what it still holds.
  for (const WorkerId sibling : registry_.Siblings(worker)) {
    DropWorker(sibling, absl::AbortedError("the worker has registered again"));
  }
  awaited_.erase(worker.hello.uuid);
  if (held.empty()) return;
  size_t tiles = 0;
  for (const HeldLease& lease : held) {
    const JobPtr job = FindLive(lease.job_id);
    const std::optional<int64_t> index =
        job == nullptr || job->ending ? std::nullopt : job->spec()->frames.IndexOf(lease.frame);
    if (!index) continue;
    const std::optional<Lease> adopted = scheduler_.Adopt(worker.id, job->key(), int(*index), lease.tiles);
    if (!adopted) continue;
    SendLease(worker, *adopted, lease.ticket);
    tiles += adopted->tiles.size();
  }
  sessions_.at(worker.id).sink->Send(AllAdopted{});
  spdlog::info("leases adopted session={} leases={} tiles={}", worker.session_id, held.size(), tiles);
}

absl::Status Farm::AwaitWorkers() {
  SL_ASSIGN_OR_RETURN(const std::vector<std::string> connected, parts_.store->ConnectedWorkers());
  absl::MutexLock lock(&mutex_);
  if (connected.empty() || parts_.config.adoption_time <= absl::ZeroDuration()) return absl::OkStatus();
  awaited_.insert(connected.begin(), connected.end());
  await_until_ = parts_.clock->Monotonic() + parts_.config.adoption_time;
  for (const auto& [key, job] : by_key_) {
    scheduler_.SetBlocked(key, TileScheduler::Block::kAdoption, true);
  }
  return absl::OkStatus();
}

void Farm::EndAdoption() {
  if (await_until_ == absl::ZeroDuration()) return;
  await_until_ = absl::ZeroDuration();
  if (!awaited_.empty()) spdlog::warn("workers did not come back workers={}", awaited_.size());
  for (const std::string& uuid : awaited_) worker_notes_.try_emplace(uuid, false);
  awaited_.clear();
  for (const auto& [key, job] : by_key_) {
    scheduler_.SetBlocked(key, TileScheduler::Block::kAdoption, false);
  }
}

void Farm::NoteWorker(const std::string& uuid) {
  const auto& entries = registry_.entries();
  worker_notes_[uuid] = std::any_of(entries.begin(), entries.end(), [&](const auto& entry) {
    return entry.second.hello.uuid == uuid && sessions_.contains(entry.first);
  });
}

}  // namespace shutterline::server
