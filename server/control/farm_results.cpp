// The part of Farm that takes results.
#include <spdlog/spdlog.h>

#include <utility>

#include "common/base/log.h"
#include "common/job/output_channels.h"
#include "server/control/farm.h"

namespace shutterline::server {

std::vector<Farm::Destination> Farm::Locate(const std::vector<const TileReport*>& reports) {
  std::vector<Destination> destinations(reports.size());
  absl::MutexLock lock(&mutex_);
  for (size_t i = 0; i < reports.size(); ++i) {
    const TileReport& report = *reports[i];
    Destination& destination = destinations[i];
    const JobPtr job = FindLive(report.job_id);
    if (job == nullptr || job->ending) {
      destination.refusal = ReportOutcome::kUnwanted;
      continue;
    }
    const TileGrid grid = job->grid();
    const std::optional<int64_t> index = job->spec()->frames.IndexOf(report.frame);
    const size_t pixel_bytes = sizeof(float) * size_t(OutputChannelCount(job->spec()->render));
    const bool fits =
        index && report.tile < uint32_t(grid.Count()) &&
        (report.failed || report.pixels.size() == size_t(grid.Rect(int(report.tile)).Area()) * pixel_bytes);
    if (!fits) {
      spdlog::warn("result does not fit its job job={} frame={} tile={} bytes={}", LogValue(report.job_id),
                   report.frame, report.tile, report.pixels.size());
      destination.refusal = ReportOutcome::kRefused;
      continue;
    }
    if (job->Frame(int(*index)).state == FrameState::kFinished) {
      destination.refusal = ReportOutcome::kUnwanted;
      continue;
    }
    destination.address = {job->key(), int(*index), report.tile};
  }
  return destinations;
}

void Farm::Apply(const std::vector<Result>& results) {
  std::vector<Quarantined> quarantined;
  {
    absl::MutexLock lock(&mutex_);
    gather_pace_.Count(int64_t(results.size()));
    for (const Result& result : results) {
      if (result.destination.refusal != ReportOutcome::kStored) continue;
      const TileAddress& at = result.destination.address;
      const auto found = by_key_.find(at.job);
      const JobPtr job = found == by_key_.end() ? nullptr : found->second;
      if (job == nullptr || job->ending) {
        parts_.journal->DropJob(at.job);  // What came between the job's end and now.
        continue;
      }
      WorkerEntry* worker = registry_.Find(result.worker);
      if (worker != nullptr) {
        worker->last_heard = parts_.clock->Monotonic();
        scheduler_.Renew(result.worker, {});
      }
      if (result.report->failed) {
        spdlog::warn("tile failed job={} frame={} tile={} worker={} reason={}", job->id(),
                     result.report->frame, at.tile, WorkerName(result.worker),
                     LogValue(result.report->failure));
        if (auto hopeless =
                scheduler_.Fail(at.job, at.frame, at.tile, result.worker, result.report->failure)) {
          quarantined.push_back(*std::move(hopeless));
        }
        continue;
      }
      if (result.stored == TileJournal::Outcome::kMismatch) {
        const std::optional<Digest> kept = parts_.journal->Find(at);
        spdlog::error(
            "tile rendered twice with different pixels job={} frame={} tile={} worker={} kept={} refused={}",
            job->id(), result.report->frame, at.tile, WorkerName(result.worker), kept ? kept->ToHex() : "",
            Sha256(result.report->pixels).ToHex());
        job->CountMismatch(NextSeq());
      }
      // Also of a duplicate: were its tile not done, for whatever reason, nobody else would ever finish it.
      if (!scheduler_.Complete(at.job, at.frame, at.tile, result.worker, result.report->render_time)) {
        // Its frame was finished while it was on its way, or the tile was given up.
        const JobQueue* queue = scheduler_.Find(at.job);
        const bool given_up = queue != nullptr && queue->IsQuarantined(at.frame, at.tile);
        if (given_up || job->Frame(at.frame).state == FrameState::kFinished) parts_.journal->Forget(at);
        continue;
      }
      if (worker != nullptr) ++worker->tiles_done;
      job->TileDone(at.frame, result.report->stats, NextSeq(), NextSeq());
      observer_.OnTileStored({job->id(), result.report->frame, at.tile, result.worker,
                              result.report->received, parts_.clock->Monotonic(),
                              result.report->render_time});
      if (result.stored == TileJournal::Outcome::kStaged && !job->snapshot().paused) {
        parts_.blocks->Add({at.job, at.frame}, *job->spec(), at.tile, result.digest,
                           std::move(result.report->pixels));
      }
      if (job->Settled(at.frame)) WriteFrameSoon(job, at.frame);
    }
    const std::vector<EndedLease> late = scheduler_.TakeRevoked();
    observer_.OnLeasesEnded(FarmObserver::LeaseEnd::kRevoked, int64_t(late.size()));
    Revoke(late, scheduler_.TakeDropped());
    Pump();
  }
  Quarantine(quarantined);
}

}  // namespace shutterline::server
