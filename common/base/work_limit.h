#pragma once

#include <absl/status/status.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/string_view.h>
#include <absl/time/time.h>

#include <atomic>
#include <cstdint>

#include "common/base/clock.h"

namespace shutterline {

/// How long work on what others have sent may take. Whoever starts the work sets the limit, for its thread
/// (WithinWorkLimit); loops whose length the input decides ask it now and then (CheckWork), and leave by an
/// exception once the time is over: libraries that call us back, TBB above all, pass nothing else on. A
/// thread without a limit is never stopped. Other threads than the one that set it are told of it by hand:
///
///     const WorkLimit* const limit = WorkLimit::Current();
///     tbb::parallel_for(..., [&](size_t i) {
///       CheckWork(limit);                  // Or, where others are called that ask it themselves:
///       const WorkLimitScope scope(limit);
///     });
///
/// Thread-safe.
class WorkLimit {
 public:
  /// From now on; `clock` must outlive it. An infinite time is no limit.
  WorkLimit(const Clock& clock, absl::Duration time)
      : clock_(clock), time_(time), start_(clock.Monotonic()) {}
  WorkLimit(const WorkLimit&) = delete;
  WorkLimit& operator=(const WorkLimit&) = delete;

  /// Of this thread; null: none.
  static const WorkLimit* Current();

  /// What is thrown. No std::exception, so that nobody takes it for an error of a library that he calls.
  struct Exceeded {
    absl::Duration time;
  };
  /// Throws Exceeded once the time is over. Takes as long as a look at the clock.
  void Check() const;

 private:
  friend class WorkLimitScope;
  friend class WorkPause;

  const Clock& clock_;
  const absl::Duration time_, start_;
  mutable std::atomic<int64_t> paused_ns_ = 0;
};

/// Throws where `limit` is one and its time is over.
inline void CheckWork(const WorkLimit* limit) {
  if (limit != nullptr) limit->Check();
}
/// The same of this thread's limit.
inline void CheckWork() {
  CheckWork(WorkLimit::Current());
}

/// Makes a limit this thread's, for as long as it lives. Null: none.
class WorkLimitScope {
 public:
  explicit WorkLimitScope(const WorkLimit* limit);
  ~WorkLimitScope();
  WorkLimitScope(const WorkLimitScope&) = delete;

 private:
  const WorkLimit* const outer_;
};

/// While it lives, this thread waits for others (a network, a disk): the time does not count against its
/// limit.
class WorkPause {
 public:
  WorkPause();
  ~WorkPause();
  WorkPause(const WorkPause&) = delete;

 private:
  const WorkLimit* const limit_;
  absl::Duration start_;
};

/// DEADLINE_EXCEEDED: "<doing>: it took longer than the 2m that are allowed".
absl::Status TookTooLong(absl::string_view doing, const WorkLimit::Exceeded& exceeded);

/// Calls `work`, whose result is a Status or a StatusOr, under a limit; TookTooLong where that ended it.
template <typename Work>
auto WithinWorkLimit(const Clock& clock, absl::Duration time, absl::string_view doing, Work&& work)
    -> decltype(work()) {
  const WorkLimit limit(clock, time);
  const WorkLimitScope scope(&limit);
  try {
    return work();
  } catch (const WorkLimit::Exceeded& exceeded) {
    return TookTooLong(doing, exceeded);
  }
}

}  // namespace shutterline
