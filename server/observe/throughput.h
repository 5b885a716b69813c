#pragma once

#include <absl/base/thread_annotations.h>
#include <absl/synchronization/mutex.h>
#include <absl/time/time.h>

#include <cstdint>
#include <vector>

#include "common/base/clock.h"
#include "server/control/observer.h"

namespace shutterline::server {

/// How many tiles came in the last ten minutes, in steps of some seconds. Thread-safe.
class Throughput final : public FarmObserver {
 public:
  static constexpr absl::Duration kStep = absl::Seconds(5);
  static constexpr int kSteps = 120;

  explicit Throughput(const Clock& clock) : clock_(clock), buckets_(size_t{kSteps}) {}

  void OnTileStored(const TileStored& seen) override;

  struct Step {
    int64_t tiles = 0;
    double render_seconds = 0;  ///< Thread time that they took.
  };
  /// The last `kSteps` steps, oldest first; the last one is not over.
  std::vector<Step> Steps() const;
  /// Tiles a second over the last whole minute.
  double TilesPerSecond() const;

 private:
  struct Bucket {
    int64_t number = -1;  ///< Of the step.
    Step step;
  };
  int64_t Now() const;  ///< Number of the step that is under way.
  Step At(int64_t number) const ABSL_SHARED_LOCKS_REQUIRED(mutex_);

  const Clock& clock_;
  mutable absl::Mutex mutex_;
  std::vector<Bucket> buckets_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace shutterline::server
