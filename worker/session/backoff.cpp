#include "worker/session/backoff.h"

#include <algorithm>

namespace shutterline::worker {

Backoff::Backoff(const Clock& clock, const BackoffOptions& options, uint64_t seed)
    : clock_(clock), options_(options), random_(seed), ceiling_(options.initial) {}

void Backoff::Connected() {
  connected_at_ = clock_.Monotonic();
}

absl::Duration Backoff::NextDelay() {
  if (connected_at_ != absl::InfiniteDuration() &&
      clock_.Monotonic() - connected_at_ >= options_.healthy_after) {
    ceiling_ = options_.initial;
  }
  connected_at_ = absl::InfiniteDuration();
  const absl::Duration ceiling = std::min(ceiling_, options_.max);
  ceiling_ = std::min(ceiling_ * options_.multiplier, options_.max);
  return ceiling * std::uniform_real_distribution<double>(0.5, 1.0)(random_);
}

}  // namespace shutterline::worker
