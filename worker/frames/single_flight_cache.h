#pragma once

#include <absl/base/thread_annotations.h>
#include <absl/status/statusor.h>
#include <absl/synchronization/mutex.h>
#include <absl/time/time.h>

#include <functional>
#include <list>
#include <memory>
#include <utility>

#include "common/base/clock.h"

namespace shutterline::worker {

/// At most `capacity` finished values, least recently used dropped first; values are made on demand, each
/// by one thread while the others that want it wait. A dropped value lives on with those who hold it.
///
/// Errors are kept like values for as long as `keep_time` says, so that a broken scene is read once and not
/// once a tile. Where that is no time, they go to those who waited, and the next caller tries again.
/// Thread-safe. Keys are compared with ==; capacities are small, so the search is linear.
template <typename Key, typename Value>
class SingleFlightCache {
 public:
  using Result = absl::StatusOr<std::shared_ptr<const Value>>;

  /// `clock` must outlive this.
  SingleFlightCache(size_t capacity, std::function<absl::Duration(const absl::Status&)> keep_time,
                    const Clock& clock = Clock::System())
      : capacity_(capacity), keep_time_(std::move(keep_time)), clock_(clock) {}

  /// `make` runs without the cache's lock and must not throw.
  Result Get(const Key& key, const std::function<Result()>& make) {
    std::shared_ptr<Entry> entry;
    {
      absl::MutexLock lock(&mutex_);
      for (auto it = entries_.begin(); it != entries_.end(); ++it) {
        if ((*it)->key == key) {
          if ((*it)->done && (*it)->until <= clock_.Monotonic()) {
            entries_.erase(it);
            break;
          }
          entries_.splice(entries_.begin(), entries_, it);
          entry = *it;
          mutex_.Await(absl::Condition(&entry->done));
          return entry->result;
        }
      }
      entry = std::make_shared<Entry>(key);
      entries_.push_front(entry);
    }
    Result result = make();
    absl::MutexLock lock(&mutex_);
    const absl::Duration keep = result.ok() ? absl::InfiniteDuration() : keep_time_(result.status());
    entry->result = std::move(result);
    entry->until = clock_.Monotonic() + keep;
    entry->done = true;
    if (keep <= absl::ZeroDuration()) entries_.remove(entry);
    DropOldestLocked();
    return entry->result;
  }

  /// Values and kept errors, and those being made.
  size_t size() const {
    absl::MutexLock lock(&mutex_);
    return entries_.size();
  }

 private:
  struct Entry {
    explicit Entry(const Key& k) : key(k) {}
    const Key key;
    bool done = false;
    absl::Duration until;  ///< Once done.
    Result result = absl::UnknownError("not made yet");
  };

  void DropOldestLocked() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    // An entry that is still being made is found by those who want it, so it stays.
    for (auto it = entries_.end(); entries_.size() > capacity_ && it != entries_.begin();) {
      --it;
      if ((*it)->done) it = entries_.erase(it);
    }
  }

  const size_t capacity_;
  const std::function<absl::Duration(const absl::Status&)> keep_time_;
  const Clock& clock_;
  mutable absl::Mutex mutex_;
  std::list<std::shared_ptr<Entry>> entries_ ABSL_GUARDED_BY(mutex_);  // Most recently used first.
};

}  // namespace shutterline::worker
