#pragma once

#include <absl/base/thread_annotations.h>
#include <absl/synchronization/mutex.h>
#include <absl/time/time.h>

#include <functional>
#include <map>
#include <utility>
#include <vector>

#include "common/base/clock.h"

namespace shutterline::server {

/// What is to be tried again after a while, in the order in which it falls due; whoever ticks runs it.
/// Thread-safe. What is still in it at the end is not run.
class LaterTasks {
 public:
  explicit LaterTasks(const Clock& clock) : clock_(clock) {}

  void Add(absl::Duration delay, std::function<void()> task) {
    absl::MutexLock lock(&mutex_);
    tasks_.emplace(clock_.Monotonic() + delay, std::move(task));
  }

  /// Takes what is due by now.
  std::vector<std::function<void()>> TakeDue() {
    absl::MutexLock lock(&mutex_);
    std::vector<std::function<void()>> due;
    const auto end = tasks_.upper_bound(clock_.Monotonic());
    for (auto task = tasks_.begin(); task != end; ++task) due.push_back(std::move(task->second));
    tasks_.erase(tasks_.begin(), end);
    return due;
  }

 private:
  const Clock& clock_;
  absl::Mutex mutex_;
  std::multimap<absl::Duration, std::function<void()>> tasks_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace shutterline::server
