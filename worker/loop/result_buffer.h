#pragma once

#include <absl/base/thread_annotations.h>
#include <absl/status/status.h>
#include <absl/synchronization/mutex.h>
#include <absl/time/time.h>

#include <cstdint>
#include <deque>
#include <memory>
#include <vector>

#include "common/base/clock.h"
#include "worker/loop/gather.h"
#include "worker/loop/tile_task.h"

namespace shutterline::worker {

/// Rendered tiles on their way to the coordinator: those not sent yet and those sent but not acknowledged.
/// A tile leaves when it is acknowledged, never before, so that a broken connection loses none.
///
///     Add*  (threads that render)          (NextBatch | Acknowledge | Rewind)*  (the session)
///
/// Memory is bounded by `max_bytes` plus one tile a thread: threads call WaitForRoom before they start a
/// tile. Thread-safe.
class ResultBuffer {
 public:
  using Result = std::shared_ptr<const TileResult>;
  struct Batch {
    uint64_t id = 0;
    std::vector<Result> results;
  };

  /// Results wait for no company until SetPace says so.
  explicit ResultBuffer(size_t max_bytes, const Clock& clock = Clock::System())
      : max_bytes_(max_bytes), clock_(clock) {}

  /// Blocks while the buffer is full. False once it is closed.
  bool WaitForRoom();
  void Add(TileResult result);

  /// The results that are to be sent next, in the order in which they were added: at least one, more while
  /// they fit into `max_bytes`. Waits for the first as long as it takes, then for company as Gather says
  /// (half of `max_bytes` is enough). Results of jobs that were forgotten are dropped. An empty batch once
  /// the buffer is interrupted or closed.
  Batch NextBatch(size_t max_bytes);
  /// How long results wait for company, from now on, those that wait included.
  void SetPace(absl::Duration pace);
  /// What waits is sent at once. False where nothing waits.
  bool Hurry();
  /// Ends NextBatch's waiting in this and later calls, until Rewind.
  void Interrupt();

  /// Batch `id`, the oldest one that is under way, has arrived: returns its results. NOT_FOUND where `id`
  /// is not the oldest, INVALID_ARGUMENT where it holds another number of results than `count`; nothing
  /// changes then.
  absl::StatusOr<std::vector<Result>> Acknowledge(uint64_t id, size_t count);

  /// A new connection: everything that was not acknowledged is to be sent again, at once, before what is new.
  /// Batch ids start again at 1.
  void Rewind();

  /// Nothing is waiting and nothing under way.
  bool Empty() const;
  size_t size() const;
  /// Waits for Empty().
  bool WaitUntilEmpty(absl::Duration timeout) const;
  void Close();

 private:
  bool HasRoomLocked() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return closed_ || bytes_ < max_bytes_; }
  bool EmptyLocked() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    return unsent_.empty() && under_way_.empty();
  }
  void DropForgottenLocked() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const size_t max_bytes_;
  const Clock& clock_;
  mutable absl::Mutex mutex_;
  std::deque<Result> unsent_ ABSL_GUARDED_BY(mutex_);
  std::deque<Batch> under_way_ ABSL_GUARDED_BY(mutex_);
  size_t bytes_ ABSL_GUARDED_BY(mutex_) = 0;  // Of all.
  Gather gather_ ABSL_GUARDED_BY(mutex_);     // Of those not sent.
  uint64_t next_batch_ ABSL_GUARDED_BY(mutex_) = 1;
  bool interrupted_ ABSL_GUARDED_BY(mutex_) = false;
  bool closed_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace shutterline::worker
