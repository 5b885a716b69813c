#include "client/retry.h"

#include <absl/random/random.h>

#include <algorithm>
#include <utility>

namespace shutterline::client {

Backoff::Backoff(const RetryPolicy& policy, Interrupt* interrupt, const Clock& clock,
                 std::function<void(absl::Duration)> sleep)
    : policy_(policy),
      interrupt_(interrupt),
      clock_(clock),
      sleep_(std::move(sleep)),
      pause_(policy.first_pause) {}

bool Backoff::PauseAfter(const absl::Status& status) {
  if (!absl::IsUnavailable(status)) return false;
  if (interrupt_ != nullptr && interrupt_->raised()) return false;
  const absl::Duration now = clock_.Monotonic();
  failing_since_ = std::min(failing_since_, now);
  const absl::Duration left = policy_.patience - (now - failing_since_);
  if (left <= absl::ZeroDuration()) return false;
  thread_local absl::BitGen random;
  const double scale = absl::Uniform(random, 1 - policy_.jitter, 1 + policy_.jitter);
  const absl::Duration pause = std::min(pause_ * scale, left);
  pause_ = std::min(pause_ * 2, policy_.longest_pause);
  if (sleep_) {
    sleep_(pause);
  } else if (interrupt_ != nullptr) {
    interrupt_->WaitFor(pause);
  } else {
    absl::SleepFor(pause);
  }
  return interrupt_ == nullptr || !interrupt_->raised();
}

void Backoff::Progress() {
  failing_since_ = absl::InfiniteDuration();
  pause_ = policy_.first_pause;
}

}  // namespace shutterline::client
