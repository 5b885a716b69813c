#pragma once

#include <absl/base/thread_annotations.h>
#include <absl/container/btree_map.h>
#include <absl/synchronization/mutex.h>

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "worker/loop/tile_task.h"

namespace shutterline::worker {

/// The leases that a worker holds, and their tiles that wait for a thread.
///
///     Grant (Take Rendered)* Acknowledged*  |  Revoke  |  Clear
///
/// A lease is *unrendered* until all its tiles have been rendered: that many leases occupy credit. It is
/// *live* until all its tiles have been acknowledged as well: heartbeats name it. Tiles leave in the order
/// in which they were granted. Lease ids mean something within a session only, from Clear to Clear; a tile
/// that was taken in an earlier one may still be reported and changes nothing. Thread-safe.
class LeaseBoard {
 public:
  /// Called (without the board's lock) whenever a lease has been rendered or revoked, so that credit can
  /// be given anew, and when nothing is left to render. Set once, before anything else.
  void OnProgress(std::function<void()> callback) { on_progress_ = std::move(callback); }

  /// False, and nothing happens, where the lease is held already.
  bool Grant(std::shared_ptr<const WorkerJob> job, uint64_t lease_id, int frame,
             std::span<const uint32_t> tiles);

  /// The next tile; blocks until there is one. Nothing once the board is closed.
  std::optional<TileTask> Take();

  /// A taken tile has been rendered (or has failed, or is not wanted any more).
  void Rendered(const TileTask& task);
  /// The coordinator has the tile.
  void Acknowledged(const TileTask& task);

  /// Forgets leases; tiles of theirs that have not been taken are dropped.
  void Revoke(std::span<const uint64_t> lease_ids);
  /// Forgets all leases: the session under which they were granted is over.
  void Clear();
  /// Number of sessions begun, by Clear.
  uint64_t session() const;
  /// Take returns nothing from now on, in all threads.
  void Close();

  /// Leases that heartbeats name, in order.
  std::vector<uint64_t> LiveLeases() const;
  size_t UnrenderedLeases() const;
  /// Nothing waits for a thread and no thread has a tile.
  bool Idle() const;

 private:
  struct Lease {
    uint32_t unrendered = 0;
    uint32_t unacknowledged = 0;
  };

  /// The task's lease, if it is held; else null.
  Lease* FindLocked(const TileTask& task) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  bool CanTakeLocked() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return closed_ || !waiting_.empty(); }

  std::function<void()> on_progress_;
  mutable absl::Mutex mutex_;
  absl::btree_map<uint64_t, Lease> leases_ ABSL_GUARDED_BY(mutex_);
  std::deque<TileTask> waiting_ ABSL_GUARDED_BY(mutex_);
  uint64_t session_ ABSL_GUARDED_BY(mutex_) = 0;
  size_t unrendered_leases_ ABSL_GUARDED_BY(mutex_) = 0;
  int taken_ ABSL_GUARDED_BY(mutex_) = 0;
  bool closed_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace shutterline::worker
