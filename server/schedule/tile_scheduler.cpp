#include "server/schedule/tile_scheduler.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "common/base/check.h"

namespace shutterline::server {
namespace {

/// Frames a worker is believed to keep set up.
constexpr size_t kHeldFrames = 4;
/// Weight of the newest tile in a mean: it forgets within some tens of tiles.
constexpr double kNewest = 0.1;
/// Leases of a job, a slot, that a worker may hold without having brought back a tile of any. Its threads may
/// all wait for a frame of it, and what it asks for beyond is meant for other jobs.
constexpr int64_t kUnprovenLeases = 16;

double Blend(double mean, double newest) {
  return mean == 0 ? newest : mean + kNewest * (newest - mean);
}

}  // namespace

void TileScheduler::AddJob(JobKey job, int frames, int columns, int rows, int priority,
                           const std::string& user, TileOrder order) {
  jobs_[job].queue = std::make_unique<JobQueue>(frames, columns, rows, order);
  shares_.Add(job, priority, user);
}

JobQueue* TileScheduler::Find(JobKey job) {
  const auto found = jobs_.find(job);
  return found == jobs_.end() ? nullptr : found->second.queue.get();
}

const JobQueue* TileScheduler::Find(JobKey job) const {
  const auto found = jobs_.find(job);
  return found == jobs_.end() ? nullptr : found->second.queue.get();
}

std::vector<EndedLease> TileScheduler::EndLeases(JobKey job) {
  std::vector<EndedLease> ended;
  for (auto& [id, worker] : workers_) {
    std::vector<LeaseId> of_job;
    for (const auto& [lease_id, lease] : worker.leases) {
      if (lease.job == job) of_job.push_back(lease_id);
    }
    for (const LeaseId lease : of_job) {
      ended.push_back({lease, id});
      EndLease(worker, worker.leases.at(lease));
    }
  }
  return ended;
}

std::vector<EndedLease> TileScheduler::RemoveJob(JobKey job) {
  std::vector<EndedLease> ended = EndLeases(job);
  for (auto& [id, worker] : workers_) worker.held.erase(job);
  jobs_.erase(job);
  shares_.Remove(job);
  return ended;
}

void TileScheduler::SetPriority(JobKey job, int priority) {
  if (jobs_.contains(job)) shares_.SetPriority(job, priority);
}

void TileScheduler::SetBlocked(JobKey job, Block block, bool blocked) {
  const auto found = jobs_.find(job);
  if (found == jobs_.end()) return;
  const auto bit = unsigned(block);
  found->second.blocks = blocked ? found->second.blocks | bit : found->second.blocks & ~bit;
}

void TileScheduler::AddWorker(WorkerId worker, const std::string& uuid, int slots, const std::string& boot_id,
                              const std::string& name) {
  SL_CHECK(!workers_.contains(worker));
  Worker& added = workers_[worker];
  added.uuid = uuid;
  added.boot_id = boot_id;
  added.name = name;
  added.slots = std::max(1, slots);
  slots_ += added.slots;
  added.last_heard = clock_.Monotonic();
  for (auto& [key, job] : jobs_) job.queue->Acquit(uuid, boot_id);
}

void TileScheduler::EndLease(Worker& worker, const Lease& lease) {
  if (JobQueue* queue = Find(lease.job)) {
    for (const uint32_t tile : lease.tiles) queue->PutBack(lease.frame, tile, lease.id);
  }
  shares_.Charge(lease.job, -lease.charged * lease.outstanding);
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

std::vector<Quarantined> TileScheduler::BuryWorker(WorkerId id, const WorkerEnd* end) {
  std::vector<Quarantined> quarantined;
  const auto found = workers_.find(id);
  if (found == workers_.end()) return quarantined;
  Blame(found->second, "its process ended while it rendered the tile", end, quarantined);
  RemoveWorker(id);
  return quarantined;
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

TileScheduler::Worker* TileScheduler::Ready(WorkerId id) {
  const auto found = workers_.find(id);
  if (found == workers_.end() || found->second.lost_until) return nullptr;
  return clock_.Monotonic() - found->second.last_heard < options_.lease_ttl ? &found->second : nullptr;
}

Lease TileScheduler::NewLease(WorkerId id, JobKey job, int frame) const {
  Lease lease;
  lease.id = next_lease_;
  lease.worker = id;
  lease.job = job;
  lease.frame = frame;
  lease.granted = lease.progressed = clock_.Monotonic();
  lease.deadline = lease.granted + options_.lease_ttl;
  return lease;
}

const Lease& TileScheduler::Enter(Worker& worker, Job& job, Lease lease) {
  SL_CHECK(!lease.tiles.empty());
  ++next_lease_;
  lease.outstanding = int(lease.tiles.size());
  lease.charged = job.tile_seconds > 0 ? job.tile_seconds : absl::ToDoubleSeconds(options_.batch_time);
  shares_.Charge(lease.job, lease.charged * lease.outstanding);

  std::deque<int>& held = worker.held[lease.job];
  const auto before = std::find(held.begin(), held.end(), lease.frame);
  if (before != held.end()) held.erase(before);
  held.push_front(lease.frame);
  if (held.size() > kHeldFrames) {
    job.queue->Leave(held.back(), lease.worker);
    held.pop_back();
  }
  worker.latest_job = lease.job;
  lease_owner_[lease.id] = lease.worker;
  worker.first_deadline = std::min(worker.first_deadline, lease.deadline);
  return worker.leases[lease.id] = std::move(lease);
}

std::optional<Lease> TileScheduler::Grant(WorkerId id) {
  Worker* worker = Ready(id);
  if (worker == nullptr) return std::nullopt;
  worker->last_asked = clock_.Monotonic();
  std::vector<JobKey> wanting;
  for (const auto& [key, job] : jobs_) {
    if (job.blocks == 0 && job.queue->queued() > 0) wanting.push_back(key);
  }
  const double slack = absl::ToDoubleSeconds(options_.share_slack) * double(std::max<int64_t>(1, slots_));
  const auto is_held_up = [&](JobKey key) {
    return kUnprovenLeases * worker->slots <=
           std::count_if(worker->leases.begin(), worker->leases.end(), [&](const auto& entry) {
             return entry.second.job == key && entry.second.progressed == entry.second.granted;
           });
  };
  for (const JobKey key : shares_.Rank(wanting, worker->latest_job, slack)) {
    if (is_held_up(key)) continue;
    if (std::optional<Lease> lease = GrantFrom(id, *worker, key, jobs_.at(key))) return lease;
  }
  return std::nullopt;
}

std::optional<Lease> TileScheduler::GrantFrom(WorkerId id, Worker& worker, JobKey key, Job& job) {
  if (IsBarred(worker, job)) return std::nullopt;
  const auto refuses = [&](const TroubleLog& log) {
    return log.failed_by.contains(worker.uuid) && AnotherWould(worker, job, &log);
  };
  const std::optional<int> frame = job.queue->ChooseFrame(worker.held[key], id, refuses);
  if (!frame) return std::nullopt;
  Lease lease = NewLease(id, key, *frame);
  JobQueue::Taken taken = job.queue->Take(*frame, BatchSize(worker, key, job), id, lease.id, refuses);
  lease.tiles = std::move(taken.tiles);
  lease.send_at_once = taken.came_back;
  return Enter(worker, job, std::move(lease));
}

std::optional<Lease> TileScheduler::Adopt(WorkerId id, JobKey key, int frame,
                                          const std::vector<uint32_t>& tiles) {
  Worker* worker = Ready(id);
  const auto job = jobs_.find(key);
  if (worker == nullptr || job == jobs_.end() || frame < 0 || frame >= job->second.queue->frame_count()) {
    return std::nullopt;
  }
  if ((job->second.blocks & ~unsigned(Block::kAdoption)) != 0) return std::nullopt;
  std::vector<uint32_t> known;
  std::copy_if(tiles.begin(), tiles.end(), std::back_inserter(known),
               [&](uint32_t tile) { return job->second.queue->Contains(frame, tile); });
  Lease lease = NewLease(id, key, frame);
  lease.tiles = job->second.queue->TakeThese(frame, known, id, lease.id);
  if (lease.tiles.empty()) return std::nullopt;
  return Enter(*worker, job->second, std::move(lease));
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

void TileScheduler::Settle(JobKey job, int frame, uint32_t tile, LeaseId holder, double seconds) {
  const auto owner = lease_owner_.find(holder);
  if (owner == lease_owner_.end()) return;
  Worker& worker = workers_.at(owner->second);
  Lease& lease = worker.leases.at(holder);
  SL_CHECK(lease.job == job && lease.frame == frame);
  SL_CHECK(std::find(lease.tiles.begin(), lease.tiles.end(), tile) != lease.tiles.end());
  // Nobody can have spent more than has passed, whatever is reported.
  const absl::Duration now = clock_.Monotonic();
  shares_.Charge(job, std::min(seconds, absl::ToDoubleSeconds(now - lease.granted)) - lease.charged);
  lease.progressed = now;
  if (--lease.outstanding == 0) {
    lease_owner_.erase(owner);
    worker.leases.erase(holder);
  }
}

bool TileScheduler::Complete(JobKey key, int frame, uint32_t tile, WorkerId id, absl::Duration render_time) {
  const auto job = jobs_.find(key);
  if (job == jobs_.end() || !job->second.queue->Contains(frame, tile)) return false;
  const Holders holders = job->second.queue->HoldersOf(frame, tile);
  if (!job->second.queue->MarkDone(frame, tile)) return false;
  double seconds = absl::ToDoubleSeconds(render_time);
  if (!(seconds > 0 && std::isfinite(seconds))) seconds = 0;
  for (const LeaseId holder : {holders.first, holders.second}) {
    const auto owner = lease_owner_.find(holder);
    if (owner == lease_owner_.end()) continue;
    const WorkerId worker = owner->second;
    Settle(key, frame, tile, holder, worker == id ? seconds : 0);
    if (worker == id) continue;
    if (lease_owner_.contains(holder)) {
      dropped_.push_back({holder, worker, tile});
    } else {
      revoked_.push_back({holder, worker});
    }
  }
  if (seconds > 0) {
    job->second.times.Add(seconds);
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

std::vector<DroppedTile> TileScheduler::TakeDropped() {
  std::erase_if(dropped_, [this](const DroppedTile& tile) { return !lease_owner_.contains(tile.lease); });
  return std::exchange(dropped_, {});
}

TileScheduler::Expired TileScheduler::Expire() {
  Expired expired;
  const absl::Duration now = clock_.Monotonic();
  for (auto& [id, worker] : workers_) {
    if (worker.lost_until && *worker.lost_until <= now) {
      Blame(worker, "its stream broke while it rendered the tile, and it did not come back", nullptr,
            expired.quarantined);
      expired.workers.push_back(id);
      continue;
    }
    if (worker.first_deadline > now) continue;
    worker.first_deadline = absl::InfiniteDuration();
    std::vector<LeaseId> over;
    for (const auto& [lease_id, lease] : worker.leases) {
      if (lease.deadline <= now) {
        over.push_back(lease_id);
      } else {
        worker.first_deadline = std::min(worker.first_deadline, lease.deadline);
      }
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
  for (const auto& [key, job] : jobs_) {
    if (job.blocks == 0) tiles += job.queue->queued();
  }
  return tiles;
}

TileScheduler::Demand TileScheduler::Remaining() const {
  Demand demand;
  for (const auto& [key, job] : jobs_) {
    // What waits for a person or another job asks for no workers.
    if ((job.blocks & ~unsigned(Block::kAdoption)) != 0) continue;
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
