#include "server/schedule/tile_scheduler.h"

#include <absl/strings/str_cat.h>

#include <algorithm>
#include <cmath>

#include "common/base/check.h"

namespace shutterline::server {
namespace {

/// Frames a worker is believed to keep set up.
constexpr size_t kHeldFrames = 4;
/// Weight of the newest tile in a mean: it forgets within some tens of tiles.
constexpr double kNewest = 0.1;

double Blend(double mean, double newest) {
  return mean == 0 ? newest : mean + kNewest * (newest - mean);
}

}  // namespace

void TileScheduler::AddJob(JobKey job, int frames, int columns, int rows) {
  jobs_[job].queue = std::make_unique<JobQueue>(frames, columns, rows);
}

JobQueue* TileScheduler::Find(JobKey job) {
  const auto found = jobs_.find(job);
  return found == jobs_.end() ? nullptr : found->second.queue.get();
}

const JobQueue* TileScheduler::Find(JobKey job) const {
  const auto found = jobs_.find(job);
  return found == jobs_.end() ? nullptr : found->second.queue.get();
}

std::vector<EndedLease> TileScheduler::RemoveJob(JobKey job) {
  std::vector<EndedLease> ended;
  for (auto& [id, worker] : workers_) {
    for (auto lease = worker.leases.begin(); lease != worker.leases.end();) {
      if (lease->second.job != job) {
        ++lease;
        continue;
      }
      ended.push_back({lease->first, id});
      lease_owner_.erase(lease->first);
      lease = worker.leases.erase(lease);
    }
    worker.held.erase(job);
  }
  jobs_.erase(job);
  return ended;
}

void TileScheduler::AddWorker(WorkerId worker, const std::string& uuid, int slots) {
  SL_CHECK(!workers_.contains(worker));
  Worker& added = workers_[worker];
  added.uuid = uuid;
  added.slots = std::max(1, slots);
  slots_ += added.slots;
  added.last_heard = clock_.Monotonic();
}

void TileScheduler::EndLease(Worker& worker, const Lease& lease) {
  if (JobQueue* queue = Find(lease.job)) {
    for (const uint32_t tile : lease.tiles) queue->PutBack(lease.frame, tile, lease.id);
  }
  lease_owner_.erase(lease.id);
  worker.leases.erase(lease.id);  // `lease` ends here.
}

std::vector<EndedLease> TileScheduler::EndAll(Worker& worker) {
  std::vector<EndedLease> ended;
  while (!worker.leases.empty()) {
    const Lease& lease = worker.leases.begin()->second;
    ended.push_back({lease.id, lease.worker});
    EndLease(worker, lease);
  }
  return ended;
}

std::vector<EndedLease> TileScheduler::RemoveWorker(WorkerId id) {
  const auto found = workers_.find(id);
  if (found == workers_.end()) return {};
  std::vector<EndedLease> ended = EndAll(found->second);
  for (const auto& [job, frames] : found->second.held) {
    JobQueue* queue = Find(job);
    for (const int frame : frames) {
      if (queue != nullptr) queue->Leave(frame, id);
    }
  }
  if (!found->second.lost_until) slots_ -= found->second.slots;
  workers_.erase(found);
  return ended;
}

void TileScheduler::LoseWorker(WorkerId id) {
  const auto found = workers_.find(id);
  if (found != workers_.end() && !found->second.lost_until) {
    found->second.lost_until = clock_.Monotonic() + options_.stream_grace;
    slots_ -= found->second.slots;
  }
}

void TileScheduler::RegainWorker(WorkerId id) {
  const auto found = workers_.find(id);
  if (found == workers_.end()) return;
  if (found->second.lost_until) slots_ += found->second.slots;
  found->second.lost_until.reset();
  found->second.last_heard = clock_.Monotonic();
}

void TileScheduler::Renew(WorkerId id, const std::vector<LeaseId>& leases) {
  const auto found = workers_.find(id);
  if (found == workers_.end()) return;
  const absl::Duration now = clock_.Monotonic();
  found->second.last_heard = now;
  for (const LeaseId lease : leases) {
    const auto held = found->second.leases.find(lease);
    if (held != found->second.leases.end()) held->second.deadline = now + options_.lease_ttl;
  }
}

int TileScheduler::BatchSize(const Worker& worker, JobKey key, const Job& job) const {
  const double seconds =
      worker.timed_job == key && worker.tile_seconds > 0 ? worker.tile_seconds : job.tile_seconds;
  if (seconds <= 0) return 1;  // The first tile of a job measures it.
  const double by_time = absl::ToDoubleSeconds(options_.batch_time) / seconds;
  const double by_rest = double(job.queue->remaining()) / double(2 * std::max<int64_t>(1, slots_));
  return int(std::clamp(std::min(by_time, by_rest), 1.0, double(options_.max_batch_tiles)));
}

std::optional<Lease> TileScheduler::Grant(WorkerId id) {
  const auto found = workers_.find(id);
  if (found == workers_.end()) return std::nullopt;
  Worker& worker = found->second;
  const absl::Duration now = clock_.Monotonic();
  if (worker.lost_until || now - worker.last_heard >= options_.lease_ttl) return std::nullopt;
  for (auto& [key, job] : jobs_) {
    if (job.queue->queued() == 0) continue;
    std::deque<int>& held = worker.held[key];
    const std::optional<int> frame = job.queue->ChooseFrame(held, id);
    SL_CHECK(frame.has_value());

    Lease lease;
    lease.id = next_lease_++;
    lease.worker = id;
    lease.job = key;
    lease.frame = *frame;
    lease.tiles = job.queue->Take(*frame, BatchSize(worker, key, job), id, lease.id);
    SL_CHECK(!lease.tiles.empty());
    lease.outstanding = int(lease.tiles.size());
    lease.deadline = now + options_.lease_ttl;

    const auto before = std::find(held.begin(), held.end(), *frame);
    if (before != held.end()) held.erase(before);
    held.push_front(*frame);
    if (held.size() > kHeldFrames) {
      job.queue->Leave(held.back(), id);
      held.pop_back();
    }
    lease_owner_[lease.id] = id;
    return worker.leases[lease.id] = lease;
  }
  return std::nullopt;
}

int64_t TileScheduler::Return(WorkerId id, const std::vector<LeaseId>& leases) {
  const auto found = workers_.find(id);
  if (found == workers_.end()) return 0;
  int64_t returned = 0;
  for (const LeaseId lease : leases) {
    const auto held = found->second.leases.find(lease);
    if (held == found->second.leases.end()) continue;
    EndLease(found->second, held->second);
    ++returned;
  }
  return returned;
}

void TileScheduler::Settle(JobKey job, int frame, uint32_t tile, LeaseId holder) {
  const auto owner = lease_owner_.find(holder);
  if (owner == lease_owner_.end()) return;
  Worker& worker = workers_.at(owner->second);
  Lease& lease = worker.leases.at(holder);
  SL_CHECK(lease.job == job && lease.frame == frame);
  SL_CHECK(std::find(lease.tiles.begin(), lease.tiles.end(), tile) != lease.tiles.end());
  if (--lease.outstanding == 0) {
    lease_owner_.erase(owner);
    worker.leases.erase(holder);
  }
}

bool TileScheduler::Complete(JobKey key, int frame, uint32_t tile, WorkerId id, absl::Duration render_time) {
  const auto job = jobs_.find(key);
  if (job == jobs_.end() || !job->second.queue->Contains(frame, tile)) return false;
  const LeaseId holder = job->second.queue->Holder(frame, tile);
  if (!job->second.queue->MarkDone(frame, tile)) return false;
  if (holder != 0) Settle(key, frame, tile, holder);

  const double seconds = absl::ToDoubleSeconds(render_time);
  if (seconds > 0 && std::isfinite(seconds)) {
    job->second.tile_seconds = Blend(job->second.tile_seconds, seconds);
    const auto found = workers_.find(id);
    if (found != workers_.end()) {
      Worker& worker = found->second;
      if (worker.timed_job != key) worker.tile_seconds = 0;
      worker.timed_job = key;
      worker.tile_seconds = Blend(worker.tile_seconds, seconds);
    }
  }
  return true;
}

std::optional<PoisonedTile> TileScheduler::Fail(JobKey key, int frame, uint32_t tile, WorkerId id,
                                                const std::string& reason) {
  JobQueue* queue = Find(key);
  if (queue == nullptr || !queue->Contains(frame, tile) || queue->IsDone(frame, tile)) return std::nullopt;
  const LeaseId holder = queue->Holder(frame, tile);
  const auto owner = lease_owner_.find(holder);
  // Somebody else may be rendering the tile by now: let them.
  if (owner != lease_owner_.end() && owner->second == id) {
    queue->PutBack(frame, tile, holder);
    Settle(key, frame, tile, holder);
  }
  if (queue->CountFailure(frame, tile) < options_.max_tile_failures) return std::nullopt;
  return PoisonedTile{key, frame, tile, reason};
}

void TileScheduler::Blame(const Worker& worker, std::vector<PoisonedTile>& poisoned) {
  // A worker renders its oldest leases, one a slot, each in order: the first unfinished tile of each may have
  // killed it, no other can have.
  int slot = 0;
  for (const auto& [id, lease] : worker.leases) {
    if (slot++ == worker.slots) break;
    JobQueue* queue = Find(lease.job);
    if (queue == nullptr) continue;
    const auto tile =
        std::find_if(lease.tiles.begin(), lease.tiles.end(), [&, &lease = lease](uint32_t candidate) {
          return queue->Holder(lease.frame, candidate) == lease.id;
        });
    if (tile == lease.tiles.end()) continue;
    const int deaths = queue->CountDeath(lease.frame, *tile, worker.uuid);
    if (deaths >= options_.max_tile_deaths) {
      poisoned.push_back(
          {lease.job, lease.frame, *tile, absl::StrCat(deaths, " workers ended while they rendered it")});
    }
  }
}

TileScheduler::Expired TileScheduler::Expire() {
  Expired expired;
  const absl::Duration now = clock_.Monotonic();
  for (auto& [id, worker] : workers_) {
    if (worker.lost_until && *worker.lost_until <= now) {
      Blame(worker, expired.poisoned);
      expired.workers.push_back(id);
      continue;
    }
    std::vector<LeaseId> over;
    for (const auto& [lease_id, lease] : worker.leases) {
      if (lease.deadline <= now) over.push_back(lease_id);
    }
    for (const LeaseId lease : over) {
      expired.leases.push_back({lease, id});
      EndLease(worker, worker.leases.at(lease));
    }
  }
  for (const WorkerId id : expired.workers) {
    const std::vector<EndedLease> ended = RemoveWorker(id);
    expired.leases.insert(expired.leases.end(), ended.begin(), ended.end());
  }
  return expired;
}

int64_t TileScheduler::LeasedTiles(WorkerId id) const {
  const auto found = workers_.find(id);
  if (found == workers_.end()) return 0;
  int64_t tiles = 0;
  for (const auto& [lease_id, lease] : found->second.leases) tiles += lease.outstanding;
  return tiles;
}

absl::Duration TileScheduler::TileTime(WorkerId id) const {
  const auto found = workers_.find(id);
  return found == workers_.end() ? absl::ZeroDuration() : absl::Seconds(found->second.tile_seconds);
}

int64_t TileScheduler::QueuedTiles() const {
  int64_t tiles = 0;
  for (const auto& [key, job] : jobs_) tiles += job.queue->queued();
  return tiles;
}

TileScheduler::Demand TileScheduler::Remaining() const {
  Demand demand;
  for (const auto& [key, job] : jobs_) {
    demand.queued += job.queue->queued();
    demand.remaining += job.queue->remaining();
    if (job.tile_seconds <= 0) {
      demand.unmeasured += job.queue->remaining();
    } else {
      demand.seconds += job.tile_seconds * double(job.queue->remaining());
    }
  }
  return demand;
}

}  // namespace shutterline::server
