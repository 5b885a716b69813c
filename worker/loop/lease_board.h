#pragma once

#include <absl/base/thread_annotations.h>
#include <absl/container/btree_map.h>
#include <absl/functional/function_ref.h>
#include <absl/synchronization/mutex.h>

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "worker/loop/tile_task.h"

namespace shutterline::worker {

/// The leases that a worker holds, and their tiles that wait for a thread.
///
///     Grant (Take FrameReady Rendered | RevokeTiles)* Acknowledged*  |  Revoke
///       |  Suspend (Adopt | DropSuspended)
///
/// A lease is *unrendered* until all its tiles have been rendered: that many leases occupy credit. It is
/// *live* until all its tiles have been acknowledged as well: heartbeats name it. Tiles leave in the order
/// in which they were granted, but one thread alone makes a frame ready: from Take of a tile of it until
/// FrameReady, others get tiles of other frames, or wait. So a scene whose import takes long holds up one
/// thread, and no other job. The same holds for a scene before its import, which serves all of its frames.
///
/// Lease ids mean something within a session only, from Suspend to Suspend. A session's end suspends its
/// leases: threads go on with their tiles, for the next session may adopt them, under new ids; what it does
/// not adopt is dropped. Thread-safe.
class LeaseBoard {
 public:
  /// Called (without the board's lock) whenever a lease has been rendered or revoked, so that credit can
  /// be given anew, and when nothing is left to render. Set once, before anything else.
  void OnProgress(std::function<void()> callback) { on_progress_ = std::move(callback); }

  /// False, and nothing happens, where the lease is held already.
  bool Grant(std::shared_ptr<const WorkerJob> job, uint64_t lease_id, int frame,
             std::span<const uint32_t> tiles, bool send_at_once = false);

  /// The next tile; blocks until there is one whose frame no other thread is making ready. Nothing once the
  /// board is closed.
  std::optional<TileTask> Take();
  /// The frame of a taken tile is ready, or (`ok` false) cannot be made so. To be called once a tile.
  void FrameReady(const TileTask& task, bool ok);

  /// A taken tile has been rendered (or has failed, or is not wanted any more). True where nothing of its
  /// frame is left to render here: whoever waits for the frame may wait for what has been rendered of it.
  bool Rendered(const TileTask& task);
  /// The coordinator has the tile.
  void Acknowledged(const TileTask& task);

  /// Forgets leases; tiles of theirs that have not been taken are dropped.
  void Revoke(std::span<const uint64_t> lease_ids);
  /// The same of those of a lease's tiles that have not been rendered; the lease goes on with the others.
  /// Nothing happens where it is not held.
  void RevokeTiles(uint64_t lease_id, std::span<const uint32_t> tiles);
  /// The session is over: its leases wait for the next to adopt them.
  void Suspend();
  struct Held {
    uint64_t ticket = 0;
    std::shared_ptr<const WorkerJob> job;
    int frame = 0;
    std::vector<uint32_t> tiles;  ///< Not acknowledged.
  };
  /// The suspended leases.
  std::vector<Held> Suspended() const;
  /// A suspended lease lives on as `lease_id`, with those of its tiles that are among `tiles`. False, and
  /// nothing happens, where there is no such lease.
  bool Adopt(uint64_t ticket, uint64_t lease_id, std::span<const uint32_t> tiles);
  /// Forgets the suspended leases, and drops their tiles that have not been taken.
  void DropSuspended();
  /// Number of sessions begun, by Suspend.
  uint64_t session() const;
  /// Take returns nothing from now on, in all threads.
  void Close();

  /// Leases that heartbeats name, in order.
  std::vector<uint64_t> LiveLeases() const;
  size_t UnrenderedLeases() const;
  /// Nothing waits for a thread and no thread has a tile.
  bool Idle() const;
  /// Threads are free and tiles wait, but all of frames that other threads are making ready: leases of other
  /// frames would be of use.
  bool Starved() const;

 private:
  struct Tile {
    uint32_t tile = 0;
    bool rendered = false;
  };
  struct Lease {
    std::shared_ptr<const WorkerJob> job;
    int frame = 0;
    std::optional<uint64_t> lease_id;  ///< Unset: suspended.
    std::vector<Tile> tiles;           ///< Not acknowledged.
    size_t unrendered = 0;
  };
  using Leases = absl::btree_map<uint64_t, Lease>;  ///< By ticket.

  void EraseLocked(Leases::iterator lease) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  /// Leaves the lease those of its tiles for which `keeps` holds; without any it is over.
  void KeepLocked(Leases::iterator lease, absl::FunctionRef<bool(const Tile&)> keeps)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  /// Takes the tiles that no lease has any more out of those that wait.
  void DropWaitingLocked() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  bool CanStartLocked(const TileTask& task) const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  std::deque<TileTask>::const_iterator NextLocked() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  bool CanTakeLocked() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    return closed_ || NextLocked() != waiting_.end();
  }

  std::function<void()> on_progress_;
  mutable absl::Mutex mutex_;
  Leases leases_ ABSL_GUARDED_BY(mutex_);
  absl::btree_map<uint64_t, uint64_t> tickets_ ABSL_GUARDED_BY(mutex_);  ///< By lease id, of this session.
  uint64_t next_ticket_ ABSL_GUARDED_BY(mutex_) = 1;
  std::deque<TileTask> waiting_ ABSL_GUARDED_BY(mutex_);
  using FrameName = std::pair<std::shared_ptr<const WorkerJob>, int>;
  std::vector<FrameName> preparing_ ABSL_GUARDED_BY(mutex_);  ///< One a thread that is at it.
  std::deque<FrameName> ready_ ABSL_GUARDED_BY(mutex_);       ///< The latest, which are not waited for.
  uint64_t session_ ABSL_GUARDED_BY(mutex_) = 0;
  size_t unrendered_leases_ ABSL_GUARDED_BY(mutex_) = 0;
  int taken_ ABSL_GUARDED_BY(mutex_) = 0;
  int idle_ ABSL_GUARDED_BY(mutex_) = 0;  ///< Threads in Take.
  bool closed_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace shutterline::worker
