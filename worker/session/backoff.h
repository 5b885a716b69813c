#pragma once

#include <absl/time/time.h>

#include <random>

#include "common/base/clock.h"

namespace shutterline::worker {

/// How long to wait between attempts to reach the coordinator.
struct BackoffOptions {
  absl::Duration initial = absl::Milliseconds(100);
  absl::Duration max = absl::Seconds(10);
  double multiplier = 2;
  /// A connection that has lived this long was a good one: the next loss starts from `initial` again.
  /// One that is accepted and dropped at once must not be retried in a tight loop.
  absl::Duration healthy_after = absl::Seconds(5);
};

/// Exponential backoff with jitter: the n-th failure in a row waits for a time drawn uniformly from the
/// upper half of min(max, initial · multiplier^n), so that the workers of a farm whose coordinator was
/// restarted do not come back in step. (Connected? NextDelay)*. Not thread-safe.
class Backoff {
 public:
  /// `clock` must outlive this. Workers pass different seeds.
  Backoff(const Clock& clock, const BackoffOptions& options, uint64_t seed);

  /// A connection stands since now.
  void Connected();

  /// An attempt failed or a connection was lost: how long to wait before the next attempt.
  absl::Duration NextDelay();

 private:
  const Clock& clock_;
  const BackoffOptions options_;
  std::mt19937_64 random_;
  absl::Duration ceiling_;
  absl::Duration connected_at_ = absl::InfiniteDuration();  // Infinite: not connected.
};

}  // namespace shutterline::worker
