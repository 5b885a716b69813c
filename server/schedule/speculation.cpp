// The part of TileScheduler that has tiles rendered twice when they keep everybody waiting.
#include <algorithm>

#include "server/schedule/tile_scheduler.h"

namespace shutterline::server {

std::vector<Lease> TileScheduler::Speculate(const std::vector<WorkerId>& idle, absl::Duration gather) {
  const absl::Duration now = clock_.Monotonic();
  struct Straggler {
    absl::Duration waited;
    const Lease* lease;
    std::vector<uint32_t> tiles;  ///< Held once, in the order in which they are rendered.
  };
  std::vector<Straggler> stragglers;
  std::map<JobKey, absl::Duration> patience;
  for (const auto& [id, worker] : workers_) {
    for (const auto& [lease_id, lease] : worker.leases) {
      const auto job = jobs_.find(lease.job);
      if (job == jobs_.end() || job->second.blocks != 0) continue;
      const auto [known, is_new] = patience.try_emplace(lease.job, absl::InfiniteDuration());
      if (is_new) {
        if (const std::optional<double> p95 = job->second.times.NinetyFifth()) {
          known->second = std::max(2 * absl::Seconds(*p95), options_.speculate_after) + gather;
        }
      }
      if (now - lease.progressed <= known->second) continue;
      Straggler straggler{now - lease.progressed, &lease, {}};
      for (const uint32_t tile : lease.tiles) {
        const Holders holders = job->second.queue->HoldersOf(lease.frame, tile);
        const TroubleLog* log = job->second.queue->TroublesOf(lease.frame, tile);
        // What may have killed one worker is not given to two.
        const bool suspect = log != nullptr && log->suspect();
        if (holders.Has(lease_id) && holders.second == 0 && !suspect) straggler.tiles.push_back(tile);
      }
      if (!straggler.tiles.empty()) stragglers.push_back(std::move(straggler));
    }
  }
  std::stable_sort(stragglers.begin(), stragglers.end(),
                   [](const Straggler& a, const Straggler& b) { return a.waited > b.waited; });

  std::vector<Lease> granted;
  for (const WorkerId id : idle) {
    Worker* worker = Ready(id);
    if (worker == nullptr) continue;
    for (Straggler& straggler : stragglers) {
      const Lease& slow = *straggler.lease;
      Job& job = jobs_.at(slow.job);
      if (straggler.tiles.empty() || workers_.at(slow.worker).uuid == worker->uuid ||
          IsBarred(*worker, job)) {
        continue;
      }
      Lease copy = NewLease(id, slow.job, slow.frame);
      copy.send_at_once = true;  // Everybody waits for it.
      const size_t count = size_t(BatchSize(*worker, slow.job, job));
      // From the end: the slow worker comes to those last.
      while (copy.tiles.size() < count && !straggler.tiles.empty()) {
        const uint32_t tile = straggler.tiles.back();
        straggler.tiles.pop_back();
        const TroubleLog* log = job.queue->TroublesOf(slow.frame, tile);
        if (log != nullptr && log->failed_by.contains(worker->uuid)) continue;
        job.queue->AddCopy(slow.frame, tile, id, copy.id);
        copy.tiles.push_back(tile);
      }
      if (copy.tiles.empty()) continue;
      granted.push_back(Enter(*worker, job, std::move(copy)));
      break;
    }
  }
  return granted;
}

}  // namespace shutterline::server
