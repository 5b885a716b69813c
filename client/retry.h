#pragma once

#include <absl/status/status.h>
#include <absl/time/time.h>

#include <functional>

#include "client/interrupt.h"
#include "common/base/clock.h"

namespace shutterline::client {

/// How long and how often a call that may be repeated is repeated while the other side is UNAVAILABLE:
/// starting, restarting or out of reach.
struct RetryPolicy {
  absl::Duration patience = absl::Seconds(10);  ///< From the first failure without progress.
  absl::Duration first_pause = absl::Milliseconds(100);
  absl::Duration longest_pause = absl::Seconds(2);
  double jitter = 0.2;  ///< A pause is scaled by up to this, so that many clients do not return at once.
};

/// Counts the pauses of one call that is repeated: NextPause* with Progress whenever something was had.
/// Not thread-safe.
class Backoff {
 public:
  /// `interrupt` ends a pause early. `clock`, where given, measures patience in its place; pauses are
  /// then taken by `sleep`.
  Backoff(const RetryPolicy& policy, Interrupt* interrupt, const Clock& clock = Clock::System(),
          std::function<void(absl::Duration)> sleep = nullptr);

  /// After a failure: pauses and returns true, or returns false at once where `status` is not UNAVAILABLE,
  /// patience is at its end or the user interrupted.
  bool PauseAfter(const absl::Status& status);
  /// Something was received: patience and pauses start afresh.
  void Progress();
  /// A pause was taken and nothing has been had since.
  bool failing() const { return failing_since_ != absl::InfiniteDuration(); }

 private:
  const RetryPolicy policy_;
  Interrupt* const interrupt_;
  const Clock& clock_;
  const std::function<void(absl::Duration)> sleep_;
  absl::Duration failing_since_ = absl::InfiniteDuration();  ///< Infinite: not failing.
  absl::Duration pause_;
};

}  // namespace shutterline::client
