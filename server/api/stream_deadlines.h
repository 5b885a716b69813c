#pragma once

#include <absl/base/thread_annotations.h>
#include <absl/synchronization/mutex.h>
#include <absl/time/time.h>

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <thread>

#include "common/base/clock.h"

namespace shutterline::server {

/// Streams that owe us a message, and until when. A peer that opens streams and says nothing would otherwise
/// hold them for ever: keepalive asks only whether its machine lives. Thread-safe.
///
///     Add Cancel*
class StreamDeadlines {
 public:
  explicit StreamDeadlines(const Clock& clock) : clock_(clock) {}

  using Id = uint64_t;
  /// `expire` is called, once and from Tick, if `within` passes before Cancel. It may call Cancel.
  Id Add(absl::Duration within, std::function<void()> expire);
  /// After this returns `expire` neither runs nor will run, but for a call that this one is made from. May
  /// be called again. The caller holds no lock that `expire` takes.
  void Cancel(Id id);
  /// Ends what has run out; to be called some times a second, by one thread.
  void Tick();

 private:
  struct Entry {
    absl::Duration deadline;
    std::function<void()> expire;
  };

  const Clock& clock_;
  absl::Mutex mutex_;
  Id last_id_ ABSL_GUARDED_BY(mutex_) = 0;
  std::map<Id, Entry> entries_ ABSL_GUARDED_BY(mutex_);
  std::optional<Id> running_ ABSL_GUARDED_BY(mutex_);
  std::thread::id runner_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace shutterline::server
