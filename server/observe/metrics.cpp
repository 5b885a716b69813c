#include "server/observe/metrics.h"

#include <absl/strings/str_cat.h>
#include <prometheus/counter.h>
#include <prometheus/gauge.h>
#include <prometheus/histogram.h>
#include <prometheus/registry.h>
#include <prometheus/text_serializer.h>

#include <array>
#include <map>

#include "server/jobs/job_state_words.h"
#include "server/observe/desired_workers.h"

namespace shutterline::server {
namespace {

using Buckets = prometheus::Histogram::BucketBoundaries;

constexpr std::array<const char*, 6> kOutcomes = {"stored",   "duplicate", "mismatch",
                                                  "unwanted", "refused",   "failed"};
constexpr std::array<const char*, 3> kLeaseEnds = {"expired", "revoked", "returned"};

/// 1 ms to 100 s in steps of about √10.
const Buckets& RenderBuckets() {
  static const auto* const buckets = new Buckets{0.001, 0.003, 0.01, 0.03, 0.1, 0.3, 1, 3, 10, 30, 100};
  return *buckets;
}
const Buckets& CommitBuckets() {
  static const auto* const buckets =
      new Buckets{0.001, 0.0025, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1, 5};
  return *buckets;
}
const Buckets& FrameBuckets() {
  static const auto* const buckets = new Buckets{0.01, 0.03, 0.1, 0.3, 1, 3, 10, 30, 100};
  return *buckets;
}

}  // namespace

struct Metrics::Series {
  prometheus::Registry registry;

  prometheus::Family<prometheus::Counter>& Counters(const char* name, const char* help) {
    return prometheus::BuildCounter().Name(name).Help(help).Register(registry);
  }
  prometheus::Counter& Counter(const char* name, const char* help) { return Counters(name, help).Add({}); }
  prometheus::Family<prometheus::Gauge>& Gauges(const char* name, const char* help) {
    return prometheus::BuildGauge().Name(name).Help(help).Register(registry);
  }
  prometheus::Gauge& Gauge(const char* name, const char* help) { return Gauges(name, help).Add({}); }
  prometheus::Histogram& Histogram(const char* name, const char* help, const Buckets& buckets) {
    return prometheus::BuildHistogram().Name(name).Help(help).Register(registry).Add({}, buckets);
  }

  // Tiles.
  prometheus::Family<prometheus::Counter>& tiles =
      Counters("shutterline_tiles_total", "Tiles that workers reported, by what became of them.");
  std::array<prometheus::Counter*, kOutcomes.size()> tiles_by_outcome{};
  prometheus::Counter& mismatches =
      Counter("shutterline_tile_mismatch_total",
              "Tiles that were rendered twice with different pixels; the first were kept. Must stay 0.");
  prometheus::Histogram& render =
      Histogram("shutterline_tile_render_seconds",
                "Thread time of stored tiles, as their workers measured it.", RenderBuckets());

  // Commits and frames.
  prometheus::Histogram& commit =
      Histogram("shutterline_commit_seconds",
                "From the arrival of a group's oldest result until the group was on disk.", CommitBuckets());
  prometheus::Counter& commit_failures =
      Counter("shutterline_commit_failures_total", "Groups of results that could not be written to disk.");
  prometheus::Counter& journal_bytes =
      Counter("shutterline_journal_written_bytes_total", "Pixels written to the journal.");
  prometheus::Histogram& frame =
      Histogram("shutterline_frame_write_seconds", "Putting a frame's tiles together and writing its file.",
                FrameBuckets());
  prometheus::Counter& frames = Counter("shutterline_frames_written_total", "Frames written as files.");
  prometheus::Counter& frame_bytes =
      Counter("shutterline_frame_written_bytes_total", "Bytes of the files of frames.");

  // Leases and workers.
  prometheus::Counter& granted =
      Counter("shutterline_leases_granted_total", "Leases that were handed to workers.");
  prometheus::Counter& granted_tiles =
      Counter("shutterline_granted_tiles_total", "Tiles in the leases that were handed to workers.");
  prometheus::Family<prometheus::Counter>& lease_ends =
      Counters("shutterline_leases_ended_total",
               "Leases that ended before all their tiles came: expired with a silent or dead worker, revoked "
               "with their job, or returned by the worker.");
  std::array<prometheus::Counter*, kLeaseEnds.size()> leases_by_end{};
  prometheus::Gauge& workers = Gauge("shutterline_workers_connected", "Workers with an open session.");
  prometheus::Gauge& draining =
      Gauge("shutterline_workers_draining", "Connected workers that take no more leases.");
  prometheus::Gauge& slots =
      Gauge("shutterline_worker_slots", "Tiles that the connected workers render at the same time.");
  prometheus::Gauge& desired =
      Gauge("shutterline_desired_workers",
            "Workers that would finish what remains within 60 s, at recent times a tile; 0 without work.");

  // Jobs.
  prometheus::Family<prometheus::Gauge>& jobs =
      Gauges("shutterline_jobs", "Jobs that have not ended, by state.");
  std::map<JobState, prometheus::Gauge*> jobs_by_state;
  prometheus::Counter& accepted = Counter("shutterline_jobs_accepted_total", "Jobs that clients submitted.");
  prometheus::Family<prometheus::Counter>& ended =
      Counters("shutterline_jobs_ended_total", "Jobs that ended, by how.");
  std::map<JobState, prometheus::Counter*> ended_by_state;
  prometheus::Counter& removed =
      Counter("shutterline_jobs_removed_total", "Jobs that had ended and were removed.");
  prometheus::Gauge& queued = Gauge("shutterline_queued_tiles", "Tiles that wait for a worker.");
  prometheus::Gauge& leased = Gauge("shutterline_leased_tiles", "Tiles that workers hold leases of.");
  prometheus::Gauge& remaining =
      Gauge("shutterline_remaining_work_seconds",
            "Thread time of the tiles that remain, at recent times of their jobs; tiles of jobs that have "
            "not been measured count nothing.");

  // Blobs and the coordinator itself.
  prometheus::Counter& blobs_in =
      Counter("shutterline_blob_received_bytes_total", "Bytes of scene files that clients uploaded.");
  prometheus::Counter& blobs_out =
      Counter("shutterline_blob_sent_bytes_total", "Bytes of scene files that workers fetched.");
  prometheus::Gauge& epoch = Gauge("shutterline_epoch", "Counts the starts of the coordinator.");
  prometheus::Family<prometheus::Gauge>& build =
      Gauges("shutterline_build_info", "1; the label says which build runs.");

  Series() {
    for (size_t i = 0; i < kOutcomes.size(); ++i)
      tiles_by_outcome[i] = &tiles.Add({{"outcome", kOutcomes[i]}});
    for (size_t i = 0; i < kLeaseEnds.size(); ++i)
      leases_by_end[i] = &lease_ends.Add({{"reason", kLeaseEnds[i]}});
    // All states from the start: a series that appears with its first job has no rate for it.
    for (const JobState state : kJobStates) {
      const std::string word(JobStateWord(state));
      if (HasEnded(state)) {
        ended_by_state[state] = &ended.Add({{"state", word}});
      } else {
        jobs_by_state[state] = &jobs.Add({{"state", word}});
      }
    }
  }
};

Metrics::Metrics(const std::string& build, uint64_t epoch) : series_(std::make_unique<Series>()) {
  series_->build.Add({{"build", build}}).Set(1);
  series_->epoch.Set(double(epoch));
}

Metrics::~Metrics() = default;

void Metrics::OnGranted(const Granted& seen) {
  series_->granted.Increment();
  series_->granted_tiles.Increment(double(seen.tiles.size()));
}

void Metrics::OnLeasesEnded(LeaseEnd end, int64_t leases) {
  if (leases > 0) series_->leases_by_end.at(size_t(end))->Increment(double(leases));
}

void Metrics::OnTile(TileOutcome outcome) {
  series_->tiles_by_outcome.at(size_t(outcome))->Increment();
  if (outcome == TileOutcome::kMismatch) series_->mismatches.Increment();
}

void Metrics::OnTileStored(const TileStored& seen) {
  series_->render.Observe(absl::ToDoubleSeconds(seen.render_time));
}

void Metrics::OnCommitted(const Committed& seen) {
  if (seen.failed) return series_->commit_failures.Increment();
  series_->commit.Observe(absl::ToDoubleSeconds(seen.longest));
  series_->journal_bytes.Increment(double(seen.journal_bytes));
}

void Metrics::OnFrameWritten(const FrameWritten& seen) {
  series_->frames.Increment();
  series_->frame_bytes.Increment(double(seen.bytes));
  series_->frame.Observe(absl::ToDoubleSeconds(seen.ended - seen.began));
}

void Metrics::OnJobAccepted(absl::string_view) {
  series_->accepted.Increment();
}

void Metrics::OnJobEnded(absl::string_view, JobState state) {
  const auto found = series_->ended_by_state.find(state);
  if (found != series_->ended_by_state.end()) found->second->Increment();
}

void Metrics::OnJobRemoved(absl::string_view) {
  series_->removed.Increment();
}

void Metrics::CountBlobBytes(uint64_t received, uint64_t sent) {
  if (received > 0) series_->blobs_in.Increment(double(received));
  if (sent > 0) series_->blobs_out.Increment(double(sent));
}

std::string Metrics::Text(const FarmTotals& totals) {
  series_->workers.Set(double(totals.workers));
  series_->draining.Set(double(totals.draining_workers));
  series_->slots.Set(double(totals.slots));
  series_->desired.Set(double(DesiredWorkers(totals, kDesiredTarget)));
  for (const auto& [state, gauge] : series_->jobs_by_state) {
    const auto count = totals.jobs.find(state);
    gauge->Set(count == totals.jobs.end() ? 0 : double(count->second));
  }
  series_->queued.Set(double(totals.queued_tiles));
  series_->leased.Set(double(totals.leased_tiles));
  series_->remaining.Set(totals.remaining_seconds);
  return prometheus::TextSerializer().Serialize(series_->registry.Collect());
}

}  // namespace shutterline::server
