#pragma once

#include <absl/time/time.h>

#include <atomic>
#include <cstdint>

#include "common/base/clock.h"

namespace shutterline::test {

/// A second passes with every look at it, so that time is the number of looks. Thread-safe.
class TickingClock final : public Clock {
 public:
  absl::Duration Monotonic() const override { return absl::Seconds(looks_++); }
  absl::Time Wall() const override { return absl::UnixEpoch(); }

  int64_t looks() const { return looks_; }

 private:
  mutable std::atomic<int64_t> looks_ = 0;
};

}  // namespace shutterline::test
