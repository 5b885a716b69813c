// The part of TileScheduler that deals with tiles that fail, or that workers die of.
#include <algorithm>
#include <utility>

#include "common/base/check.h"
#include "server/schedule/tile_scheduler.h"

namespace shutterline::server {

bool TileScheduler::HasFailedEnough(const std::string& uuid, const Job& job) const {
  const auto failed = job.failed_by.find(uuid);
  return failed != job.failed_by.end() && int(failed->second.size()) >= options_.max_worker_failures;
}

bool TileScheduler::IsBarred(const Worker& worker, const Job& job) const {
  return HasFailedEnough(worker.uuid, job) && AnotherWould(worker, job, nullptr);
}

bool TileScheduler::AnotherWould(const Worker& worker, const Job& job, const TroubleLog* log) const {
  const absl::Duration now = clock_.Monotonic();
  return std::any_of(workers_.begin(), workers_.end(), [&](const auto& entry) {
    const Worker& other = entry.second;
    return other.uuid != worker.uuid && !other.lost_until && now - other.last_heard < options_.lease_ttl &&
           now - other.last_asked < options_.second_opinion && !HasFailedEnough(other.uuid, job) &&
           (log == nullptr || !log->failed_by.contains(other.uuid));
  });
}

std::optional<Quarantined> TileScheduler::QuarantineIfHopeless(JobKey key, JobQueue& queue, int frame,
                                                               uint32_t tile) {
  const TroubleLog* log = queue.TroublesOf(frame, tile);
  SL_CHECK(log != nullptr);
  const bool hopeless = log->failures >= options_.max_tile_failures ||
                        int(log->dead.size()) >= options_.max_tile_deaths ||
                        log->deaths >= options_.max_deaths_at_all;
  // A copy of it may yet succeed.
  if (!hopeless || queue.HoldersOf(frame, tile).first != 0) return std::nullopt;
  Quarantined quarantined{key, frame, tile, log->evidence};
  queue.Quarantine(frame, tile);
  return quarantined;
}

std::optional<Quarantined> TileScheduler::Fail(JobKey key, int frame, uint32_t tile, WorkerId id,
                                               const std::string& reason) {
  const auto job = jobs_.find(key);
  if (job == jobs_.end()) return std::nullopt;
  JobQueue& queue = *job->second.queue;
  if (!queue.Contains(frame, tile) || queue.IsDone(frame, tile) || queue.IsQuarantined(frame, tile)) {
    return std::nullopt;
  }
  // Only who holds the tile is believed. Another holder may go on rendering it.
  const Holders holders = queue.HoldersOf(frame, tile);
  for (const LeaseId holder : {holders.first, holders.second}) {
    const auto owner = lease_owner_.find(holder);
    if (owner == lease_owner_.end() || owner->second != id) continue;
    const Worker& worker = workers_.at(id);
    queue.AddTrouble(frame, tile, {worker.uuid, worker.name, false, reason, clock_.Wall(), {}, {}, {}});
    job->second.failed_by[worker.uuid].insert({frame, tile});
    queue.PutBack(frame, tile, holder);
    Settle(key, frame, tile, holder, 0);
    return QuarantineIfHopeless(key, queue, frame, tile);
  }
  return std::nullopt;
}

void TileScheduler::Blame(const Worker& worker, const std::string& reason, const WorkerEnd* end,
                          std::vector<Quarantined>& quarantined) {
  // The same process, under another registration, is not dead.
  const bool lives = std::any_of(workers_.begin(), workers_.end(), [&](const auto& entry) {
    const Worker& other = entry.second;
    return &other != &worker && !other.lost_until && other.uuid == worker.uuid && !other.boot_id.empty() &&
           other.boot_id == worker.boot_id;
  });
  if (lives) return;
  // Unless more is known: a worker mostly renders its oldest leases, one a slot, each in order, so the first
  // unfinished tile of each may have killed it. (It passes over frames that are being made ready.)
  int slot = 0;
  for (const auto& [id, lease] : worker.leases) {
    if (end == nullptr && slot++ == worker.slots) break;
    const JobQueue* queue = Find(lease.job);
    if (queue == nullptr) continue;
    for (const uint32_t tile : lease.tiles) {
      if (!queue->HoldersOf(lease.frame, tile).Has(lease.id)) continue;
      if (end == nullptr || end->WasAt(lease.job, lease.frame, tile)) {
        BlameTile(worker, lease, tile, reason, end, quarantined);
      }
      if (end == nullptr) break;
    }
  }
}

void TileScheduler::BlameTile(const Worker& worker, const Lease& lease, uint32_t tile,
                              const std::string& reason, const WorkerEnd* end,
                              std::vector<Quarantined>& quarantined) {
  JobQueue& queue = *Find(lease.job);
  TileTrouble trouble{worker.uuid, worker.name, true, reason, clock_.Wall(), {}, {}, worker.boot_id};
  if (end != nullptr) (void)end->process.AddTo(worker.uuid, trouble);
  queue.AddTrouble(lease.frame, tile, std::move(trouble));
  queue.PutBack(lease.frame, tile, lease.id);
  if (auto hopeless = QuarantineIfHopeless(lease.job, queue, lease.frame, tile)) {
    quarantined.push_back(*std::move(hopeless));
  }
}

void TileScheduler::Testify(const std::string& worker_uuid, const WorkerEnd& end) {
  const bool acquits =
      end.tiles.empty() || std::any_of(end.tiles.begin(), end.tiles.end(), [&](const WorkerEnd::Tile& at) {
        const JobQueue* queue = Find(at.job);
        return queue == nullptr || !queue->Contains(at.frame, at.tile) || queue->IsDone(at.frame, at.tile) ||
               queue->Blames(at.frame, at.tile, worker_uuid, end.process.boot_id);
      });
  for (auto& [key, job] : jobs_) {
    job.queue->Testify(worker_uuid, end.process, [&, key = key](int frame, uint32_t tile) {
      return acquits && !end.WasAt(key, frame, tile);
    });
  }
}

}  // namespace shutterline::server
