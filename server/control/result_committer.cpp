#include "server/control/result_committer.h"

#include <absl/strings/str_cat.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <string>
#include <utility>

#include "common/base/log.h"
#include "common/base/retry_hint.h"

namespace shutterline::server {

static_assert(int(ReportOutcome::kStored) == int(TileOutcome::kStored) &&
              int(ReportOutcome::kDuplicate) == int(TileOutcome::kDuplicate) &&
              int(ReportOutcome::kMismatch) == int(TileOutcome::kMismatch) &&
              int(ReportOutcome::kUnwanted) == int(TileOutcome::kUnwanted) &&
              int(ReportOutcome::kRefused) == int(TileOutcome::kRefused));

ResultCommitter::ResultCommitter(Farm& farm, TileJournal& journal, absl::Duration interval, int enough_tiles)
    : farm_(farm), journal_(journal), interval_(interval), enough_tiles_(size_t(enough_tiles)) {
  thread_ = std::thread([this] { Work(); });
}

ResultCommitter::~ResultCommitter() {
  Stop();
}

void ResultCommitter::Enqueue(WorkerId worker, std::vector<TileReport> tiles, Done done) {
  {
    const absl::Duration now = farm_.clock().Monotonic();
    for (TileReport& tile : tiles) tile.received = now;
    absl::MutexLock lock(&mutex_);
    if (!stopping_) {
      queued_tiles_ += tiles.size();
      queue_.push_back({worker, std::move(tiles), std::move(done)});
      return;
    }
  }
  done(absl::UnavailableError("the coordinator is stopping"), {});
}

void ResultCommitter::Stop() {
  {
    absl::MutexLock lock(&mutex_);
    stopping_ = true;
  }
  if (thread_.joinable()) thread_.join();
}

void ResultCommitter::Work() {
  while (true) {
    std::deque<Batch> batches;
    {
      const auto any = [this]() ABSL_SHARED_LOCKS_REQUIRED(mutex_) { return stopping_ || !queue_.empty(); };
      const auto enough = [this]() ABSL_SHARED_LOCKS_REQUIRED(mutex_) {
        return stopping_ || queued_tiles_ >= enough_tiles_;
      };
      absl::MutexLock lock(&mutex_, absl::Condition(&any));
      if (queue_.empty()) return;
      mutex_.AwaitWithTimeout(absl::Condition(&enough), interval_);
      batches.swap(queue_);
      queued_tiles_ = 0;
    }
    Commit(std::move(batches));
  }
}

void ResultCommitter::Commit(std::deque<Batch> batches) {
  std::vector<const TileReport*> reports;
  for (const Batch& batch : batches) {
    for (const TileReport& tile : batch.tiles) reports.push_back(&tile);
  }
  const std::vector<Farm::Destination> destinations = farm_.Locate(reports);
  std::vector<Farm::Result> results;
  results.reserve(reports.size());
  for (Batch& batch : batches) {
    for (TileReport& tile : batch.tiles) {
      Farm::Result result{
          &tile, destinations[results.size()], batch.worker, TileJournal::Outcome::kStaged, {}};
      if (!tile.failed && result.destination.refusal == ReportOutcome::kStored) {
        result.digest = Sha256(tile.pixels);
        result.stored = journal_.Stage(result.destination.address, result.digest, tile.pixels);
      }
      results.push_back(result);
    }
  }
  const absl::Status committed = journal_.Commit();
  FarmObserver::Committed group{int64_t(results.size()), 0, absl::ZeroDuration(), !committed.ok()};
  const absl::Duration durable = farm_.clock().Monotonic();
  for (const Farm::Result& result : results) {
    group.longest = std::max(group.longest, durable - result.report->received);
    const bool stored = !result.report->failed && result.destination.refusal == ReportOutcome::kStored &&
                        result.stored == TileJournal::Outcome::kStaged;
    if (stored && committed.ok()) group.journal_bytes += int64_t(result.report->pixels.size());
  }
  farm_.observer().OnCommitted(group);
  if (!committed.ok()) {
    spdlog::error("results could not be stored tiles={} reason={}", reports.size(),
                  LogValue(committed.message()));
    // The workers keep what is not acknowledged and send it again.
    const absl::Status status = WithRetryHint(absl::UnavailableError(committed.message()), absl::Seconds(1));
    for (const Batch& batch : batches) batch.done(status, {});
    return;
  }
  farm_.Apply(results);
  size_t next = 0;
  for (const Batch& batch : batches) {
    std::vector<ReportOutcome> outcomes;
    for (size_t i = 0; i < batch.tiles.size(); ++i, ++next) {
      ReportOutcome outcome = results[next].destination.refusal;
      if (results[next].stored == TileJournal::Outcome::kDuplicate) outcome = ReportOutcome::kDuplicate;
      if (results[next].stored == TileJournal::Outcome::kMismatch) outcome = ReportOutcome::kMismatch;
      outcomes.push_back(outcome);
      farm_.observer().OnTile(batch.tiles[i].failed && outcome == ReportOutcome::kStored
                                  ? TileOutcome::kFailed
                                  : TileOutcome(outcome));
    }
    batch.done(absl::OkStatus(), outcomes);
  }
}

}  // namespace shutterline::server
