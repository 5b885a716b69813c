#pragma once

#include <absl/synchronization/mutex.h>

namespace shutterline {

/// Turns off the search for cycles in the order of locks, which Debian's Abseil does at every Mutex also in
/// optimized programs. First of all in each program's `main`; tests do without, so that they go on searching.
inline void TrustLockOrder() {
  absl::SetMutexDeadlockDetectionMode(absl::OnDeadlockCycle::kIgnore);
}

}  // namespace shutterline
