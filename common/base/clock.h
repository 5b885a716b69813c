#pragma once

#include <absl/time/time.h>

namespace shutterline {

/// Time as an interface, so that whatever waits, expires or measures can be tested without waiting.
/// Implementations are thread-safe.
class Clock {
 public:
  virtual ~Clock() = default;
  /// Monotonic time since an arbitrary start: for durations, leases and time-outs.
  virtual absl::Duration Monotonic() const = 0;
  /// Wall time: for people and file headers only, never for a decision.
  virtual absl::Time Wall() const = 0;

  /// The machine's clock; lives for ever.
  static const Clock& System();
};

}  // namespace shutterline
