#pragma once

#include <absl/time/time.h>

#include <cstdint>
#include <memory>
#include <string>

#include "server/control/events.h"
#include "server/control/observer.h"

namespace shutterline::server {

/// The coordinator's metrics, as Prometheus reads them. docs/observability.md tells what each means; every
/// name ends in its unit or in what it counts, and each has a sentence of help. Thread-safe.
class Metrics final : public FarmObserver {
 public:
  /// Time within which DesiredWorkers wants what is left to be done.
  static constexpr absl::Duration kDesiredTarget = absl::Seconds(60);

  /// `build` and `epoch` become constant metrics.
  Metrics(const std::string& build, uint64_t epoch);
  ~Metrics() override;

  void OnGranted(const Granted& seen) override;
  void OnLeasesEnded(LeaseEnd end, int64_t leases) override;
  void OnTile(TileOutcome outcome) override;
  void OnTileStored(const TileStored& seen) override;
  void OnCommitted(const Committed& seen) override;
  void OnFrameWritten(const FrameWritten& seen) override;
  void OnJobAccepted(absl::string_view job_id) override;
  void OnJobEnded(absl::string_view job_id, JobState state) override;
  void OnJobRemoved(absl::string_view job_id) override;
  void CountBlobBytes(uint64_t received, uint64_t sent);

  /// All metrics in Prometheus' text format, with the farm as it is now.
  std::string Text(const FarmTotals& totals);

 private:
  struct Series;
  std::unique_ptr<Series> series_;
};

}  // namespace shutterline::server
