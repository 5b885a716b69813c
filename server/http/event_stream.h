#pragma once

#include <absl/base/thread_annotations.h>
#include <absl/synchronization/mutex.h>
#include <absl/time/time.h>

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>

#include "server/control/farm.h"
#include "server/observe/throughput.h"

namespace shutterline::server {

/// Ends all streams at once: they wait here between looks.
class StreamGate {
 public:
  static constexpr int kMaxStreams = 16;

  /// Room for a stream; false where there are kMaxStreams, or the gate is closed. Leave gives it back.
  bool Enter();
  void Leave();
  void Close();
  /// Waits; false once the gate is closed.
  bool Wait(absl::Duration time);

 private:
  absl::Mutex mutex_;
  int streams_ ABSL_GUARDED_BY(mutex_) = 0;
  bool closed_ ABSL_GUARDED_BY(mutex_) = false;
};

/// The server-sent events of one reader:
///
///     id: 1099511627790            the change's number, for Last-Event-ID; grows over restarts
///     event: job                   or "frame", of the stream of one job
///     data: {"id": …}              as the API tells it
///
/// and "farm" (without a number) every second: totals and throughput. Events say the state that holds, not
/// the way to it. Not thread-safe.
class EventStream {
 public:
  /// `job_id`: changes of this job and of its frames; empty: of all jobs in memory. After change `after`.
  EventStream(Farm& farm, const Throughput& throughput, const Clock& clock, std::string job_id,
              uint64_t after);

  /// What is to be sent now; may be empty.
  std::string Next();

 private:
  std::string JobEvents();
  std::string FarmEvent();

  Farm& farm_;
  const Throughput& throughput_;
  const Clock& clock_;
  const std::string job_id_;
  uint64_t after_;
  absl::Duration next_farm_ = -absl::InfiniteDuration();
};

}  // namespace shutterline::server
