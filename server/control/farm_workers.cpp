// The part of Farm that workers use.
#include <absl/strings/escaping.h>
#include <absl/strings/str_cat.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <optional>

#include "common/base/check.h"
#include "common/base/log.h"
#include "common/base/status_macros.h"
#include "server/control/farm.h"

namespace shutterline::server {
namespace {

/// Far beyond what a worker of kMaxSlots can use; keeps a hostile sum from overflowing.
constexpr int64_t kMaxCredit = 1 << 20;

}  // namespace

absl::StatusOr<WorkerEntry> Farm::Register(const WorkerHello& hello) {
  absl::MutexLock lock(&mutex_);
  if (draining_) return absl::UnavailableError("the coordinator is about to stop");
  absl::StatusOr<WorkerEntry*> entry = registry_.Register(hello, parts_.clock->Monotonic());
  if (!entry.ok()) {
    spdlog::warn("worker refused worker={} name={} reason={}", LogValue(hello.uuid.substr(0, 256)),
                 LogValue(hello.name.substr(0, 256)), LogValue(entry.status().message()));
    return entry.status();
  }
  spdlog::info("worker registered worker={} name={} slots={} isa={} session={}", LogValue(hello.uuid),
               LogValue(hello.name), hello.slots, LogValue(hello.isa), (*entry)->session_id);
  for (const WorkerId id : registry_.Predecessors(**entry)) {
    // Its process is gone, whatever it was at.
    const auto exit = std::find_if(hello.exits.begin(), hello.exits.end(), [&](const WorkerExit& e) {
      return e.boot_id == registry_.Find(id)->hello.boot_id;
    });
    std::optional<WorkerEnd> end;
    if (exit != hello.exits.end()) end = EndOf(*exit);
    for (Quarantined& tile : scheduler_.BuryWorker(id, end ? &*end : nullptr))
      buried_.push_back(std::move(tile));
    DropWorker(id, absl::AbortedError("the worker has started anew"));
  }
  for (const WorkerExit& exit : hello.exits) Testify(hello, exit);
  Pump();
  return **entry;
}

absl::StatusOr<WorkerId> Farm::FindSession(const std::string& session_id, uint64_t epoch) {
  if (epoch != parts_.epoch) {
    return absl::AbortedError(
        absl::StrCat("epoch ", epoch, " is over, the current one is ", parts_.epoch, "; register again"));
  }
  absl::MutexLock lock(&mutex_);
  const WorkerEntry* entry = registry_.FindSession(session_id);
  if (entry == nullptr) {
    return absl::AbortedError(
        absl::StrCat("session '", absl::CHexEscape(session_id.substr(0, 80)), "' is over; register again"));
  }
  return entry->id;
}

absl::StatusOr<WorkerId> Farm::Attach(const std::string& session_id, uint64_t epoch,
                                      const std::vector<HeldLease>& held, WorkerSink* sink) {
  SL_ASSIGN_OR_RETURN(const WorkerId id, FindSession(session_id, epoch));
  absl::MutexLock lock(&mutex_);
  WorkerEntry* entry = registry_.Find(id);
  if (entry == nullptr) return absl::AbortedError("the session is over; register again");
  const bool is_new = !sessions_.contains(id);
  Session& session = sessions_[id];
  if (session.sink != nullptr)
    session.sink->Close(absl::AbortedError("another stream has taken the session over"));
  session.sink = sink;
  session.announced.clear();
  if (is_new) {
    scheduler_.AddWorker(id, entry->hello.uuid, int(entry->hello.slots), entry->hello.boot_id,
                         entry->hello.name);
  } else {
    scheduler_.RegainWorker(id);
  }
  entry->attached = true;
  entry->credit = 0;
  wanting_.erase(id);
  entry->last_heard = parts_.clock->Monotonic();
  Adopt(*entry, held);
  NoteWorker(entry->hello.uuid);
  if (awaited_.empty()) EndAdoption();
  if (draining_) sink->Send(DrainAsked{});
  Pump();
  return id;
}

void Farm::Detach(WorkerId id, WorkerSink* sink, bool orderly) {
  absl::MutexLock lock(&mutex_);
  const auto session = sessions_.find(id);
  if (session == sessions_.end() || session->second.sink != sink) return;  // Taken over or dropped.
  session->second.sink = nullptr;
  wanting_.erase(id);
  WorkerEntry* entry = registry_.Find(id);
  SL_CHECK(entry != nullptr);
  entry->attached = false;
  spdlog::info("worker left worker={} session={} orderly={}", LogValue(entry->hello.uuid), entry->session_id,
               orderly);
  if (orderly) {
    DropWorker(id, absl::OkStatus());
    Pump();
  } else {
    scheduler_.LoseWorker(id);
  }
}

std::string Farm::WorkerName(WorkerId id) {
  const WorkerEntry* entry = registry_.Find(id);
  return entry == nullptr ? "gone" : LogValue(entry->hello.uuid);
}

void Farm::DropWorker(WorkerId id, const absl::Status& status) {
  const auto session = sessions_.find(id);
  if (session != sessions_.end()) {
    if (session->second.sink != nullptr) session->second.sink->Close(status);
    sessions_.erase(session);
  }
  wanting_.erase(id);
  // A worker that left in order had nothing left, or gave it back so; one that started anew lost it.
  observer_.OnLeasesEnded(FarmObserver::LeaseEnd::kReturned, int64_t(scheduler_.RemoveWorker(id).size()));
  const WorkerEntry* entry = registry_.Find(id);
  if (entry == nullptr) return;
  const std::string uuid = entry->hello.uuid;
  registry_.Remove(id);
  NoteWorker(uuid);
}

void Farm::AddCredit(WorkerId id, int64_t leases) {
  absl::MutexLock lock(&mutex_);
  WorkerEntry* entry = registry_.Find(id);
  if (entry == nullptr || !entry->attached || leases <= 0) return;
  entry->last_heard = parts_.clock->Monotonic();
  scheduler_.Renew(id, {});
  entry->credit = std::min(kMaxCredit, entry->credit + std::min(kMaxCredit, leases));
  wanting_.insert(id);
  while (GrantOne(*entry)) {
  }
}

void Farm::Heartbeat(WorkerId id, const std::vector<LeaseId>& leases) {
  absl::MutexLock lock(&mutex_);
  WorkerEntry* entry = registry_.Find(id);
  if (entry == nullptr) return;
  entry->last_heard = parts_.clock->Monotonic();
  scheduler_.Renew(id, leases);
}

void Farm::ReturnLeases(WorkerId id, const std::vector<LeaseId>& leases) {
  absl::MutexLock lock(&mutex_);
  observer_.OnLeasesEnded(FarmObserver::LeaseEnd::kReturned, scheduler_.Return(id, leases));
  Pump();
}

void Farm::WorkerDrains(WorkerId id) {
  absl::MutexLock lock(&mutex_);
  WorkerEntry* entry = registry_.Find(id);
  if (entry == nullptr) return;
  entry->draining = true;
  wanting_.erase(id);
}

void Farm::Drain() {
  absl::MutexLock lock(&mutex_);
  draining_ = true;
  wanting_.clear();
  for (auto& [id, session] : sessions_) {
    if (session.sink != nullptr) session.sink->Send(DrainAsked{});
  }
}

void Farm::CloseSessions(const absl::Status& status) {
  absl::MutexLock lock(&mutex_);
  draining_ = true;
  wanting_.clear();
  for (auto& [id, session] : sessions_) {
    if (session.sink != nullptr) session.sink->Close(status);
    session.sink = nullptr;
    if (WorkerEntry* entry = registry_.Find(id)) entry->attached = false;
  }
}

bool Farm::GrantOne(WorkerEntry& worker) {
  if (draining_ || worker.draining || worker.credit <= 0) {
    wanting_.erase(worker.id);
    return false;
  }
  const auto session = sessions_.find(worker.id);
  if (session == sessions_.end() || session->second.sink == nullptr) return false;
  const std::optional<Lease> lease = scheduler_.Grant(worker.id);
  if (!lease) return false;
  SendLease(worker, *lease, 0);
  if (--worker.credit == 0) wanting_.erase(worker.id);
  return true;
}

void Farm::SendLease(WorkerEntry& worker, const Lease& lease, LeaseId adopts) {
  Session& session = sessions_.at(worker.id);
  const JobPtr& job = by_key_.at(lease.job);
  if (session.announced.insert(job->id()).second) session.sink->Send(JobAnnounced{job->id(), job->spec()});
  session.sink->Send(LeaseGranted{lease.id, job->id(), job->spec()->frames.Frame(lease.frame), lease.tiles,
                                  lease.send_at_once, adopts});
  observer_.OnGranted({lease.id, worker.id, worker.hello.uuid, worker.hello.name, job->id(),
                       job->spec()->frames.Frame(lease.frame), lease.tiles, parts_.clock->Monotonic()});
  spdlog::debug("lease granted lease={} worker={} job={} frame={} tiles={}", lease.id,
                LogValue(worker.hello.uuid), job->id(), job->spec()->frames.Frame(lease.frame),
                lease.tiles.size());
}

void Farm::Speculate() {
  if (draining_ || wanting_.empty() || scheduler_.QueuedTiles() > 0) return;
  std::vector<WorkerId> idle;
  for (const WorkerId id : wanting_) {
    const WorkerEntry* worker = registry_.Find(id);
    const auto session = sessions_.find(id);
    const bool reachable = session != sessions_.end() && session->second.sink != nullptr;
    if (worker != nullptr && worker->credit > 0 && !worker->draining && reachable) idle.push_back(id);
  }
  for (const Lease& copy : scheduler_.Speculate(idle, gather_pace_.longest())) {
    WorkerEntry& worker = *registry_.Find(copy.worker);
    SendLease(worker, copy, 0);
    if (--worker.credit == 0) wanting_.erase(worker.id);
    const LiveJob& job = *by_key_.at(copy.job);
    spdlog::info("tiles are late and are rendered twice job={} frame={} tiles={} worker={}", job.id(),
                 job.spec()->frames.Frame(copy.frame), copy.tiles.size(), LogValue(worker.hello.uuid));
  }
}

void Farm::Pump() {
  // One lease each in turn, so that a small job is spread over all who want work.
  bool granted = true;
  while (granted && !wanting_.empty() && scheduler_.QueuedTiles() > 0) {
    granted = false;
    const std::vector<WorkerId> wanting(wanting_.begin(), wanting_.end());
    for (const WorkerId id : wanting) {
      if (WorkerEntry* entry = registry_.Find(id)) granted |= GrantOne(*entry);
    }
  }
}

void Farm::Revoke(const std::vector<EndedLease>& ended, const std::vector<DroppedTile>& dropped) {
  std::map<WorkerId, LeasesRevoked> by_worker;
  for (const EndedLease& lease : ended) by_worker[lease.worker].leases.push_back(lease.id);
  for (const DroppedTile& tile : dropped) by_worker[tile.worker].tiles[tile.lease].push_back(tile.tile);
  for (auto& [worker, revoked] : by_worker) {
    const auto session = sessions_.find(worker);
    if (session != sessions_.end() && session->second.sink != nullptr) {
      session->second.sink->Send(std::move(revoked));
    }
  }
}

}  // namespace shutterline::server
