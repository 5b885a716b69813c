// The part of Farm that hears how processes of workers ended.
#include <spdlog/spdlog.h>

#include <algorithm>

#include "common/base/log.h"
#include "server/control/farm.h"

namespace shutterline::server {
namespace {

constexpr absl::Duration kStoreAgain = absl::Seconds(1);
constexpr size_t kLoggedTail = 500;
constexpr size_t kLoggedExits = 1000;

absl::string_view LastBytes(absl::string_view text, size_t count) {
  return text.size() <= count ? text : text.substr(text.size() - count);
}

}  // namespace

WorkerEnd Farm::EndOf(const WorkerExit& exit) {
  WorkerEnd end{{exit.boot_id, SignalName(exit.signal), exit.log_tail}, {}};
  for (const TileName& name : exit.tiles) {
    const JobPtr job = FindLive(name.job_id);
    if (job == nullptr) continue;
    const std::optional<int64_t> index = job->spec()->frames.IndexOf(name.frame);
    if (index) end.tiles.push_back({job->key(), int(*index), name.tile});
  }
  return end;
}

void Farm::Testify(const WorkerHello& hello, const WorkerExit& exit) {
  const WorkerEnd end = EndOf(exit);
  LogExit(hello, end);
  // Of tiles that are not done, of those whose quarantine is on its way to the disk, and of those on it.
  scheduler_.Testify(hello.uuid, end);
  for (std::vector<Quarantined>* tiles : {&buried_, &unstored_}) {
    for (Quarantined& tile : *tiles) {
      for (TileTrouble& trouble : tile.evidence) end.process.AddTo(hello.uuid, trouble);
    }
  }
  for (const auto& [id, job] : jobs_) {
    for (const auto& [frame, tile] : job->Testify(hello.uuid, end.process)) {
      later_.Add(absl::ZeroDuration(),
                 [this, job = job, frame = frame, tile = tile] { StoreEvidence(job, frame, tile); });
    }
  }
}

void Farm::LogExit(const WorkerHello& hello, const WorkerEnd& end) {
  // Workers say it again each time they register.
  std::pair<std::string, std::string> process(hello.uuid, end.process.boot_id);
  if (std::find(logged_exits_.begin(), logged_exits_.end(), process) != logged_exits_.end()) return;
  logged_exits_.push_back(std::move(process));
  if (logged_exits_.size() > kLoggedExits) logged_exits_.pop_front();
  spdlog::warn("worker process died worker={} name={} signal={} tiles={} boot={}", LogValue(hello.uuid),
               LogValue(hello.name), end.process.signal, end.tiles.size(), LogValue(end.process.boot_id));
  for (const WorkerEnd::Tile& at : end.tiles) {
    // Jobs' logs hear of it where the worker held their tile, whatever it says.
    const JobQueue* queue = scheduler_.Find(at.job);
    if (queue == nullptr || !queue->Blames(at.frame, at.tile, hello.uuid, end.process.boot_id)) continue;
    const LiveJob& job = *by_key_.at(at.job);
    spdlog::warn("worker process died at a tile job={} frame={} tile={} worker={} signal={} log_tail={}",
                 job.id(), job.spec()->frames.Frame(at.frame), at.tile, LogValue(hello.uuid),
                 end.process.signal, LogValue(LastBytes(end.process.log_tail, kLoggedTail)));
  }
}

void Farm::StoreEvidence(const JobPtr& job, int index, uint32_t tile) {
  absl::MutexLock control_lock(&control_mutex_);
  QuarantinedTile record;
  {
    absl::MutexLock lock(&mutex_);
    // A retry has begun it anew, or it has been removed: the store holds nothing of it to add to.
    const JobPtr live = FindLive(job->id());
    if ((live != nullptr && live != job) || removed_.contains(job->key())) return;
    const auto found = job->quarantined().find({index, tile});
    if (found == job->quarantined().end()) return;  // Released meanwhile.
    record = found->second;
  }
  const absl::Status stored = parts_.store->Quarantine(job->key(), record);
  if (stored.ok()) return;
  spdlog::error("evidence could not be stored, trying again job={} frame={} tile={} reason={}", job->id(),
                record.frame, tile, LogValue(stored.message()));
  later_.Add(kStoreAgain, [this, job, index, tile] { StoreEvidence(job, index, tile); });
}

}  // namespace shutterline::server
