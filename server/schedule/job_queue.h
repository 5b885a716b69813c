#pragma once

#include <absl/container/flat_hash_map.h>
#include <absl/container/flat_hash_set.h>
#include <absl/time/time.h>

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "server/schedule/lease.h"

namespace shutterline::server {

/// The tiles of one job: each is queued, leased or done. Queued -> leased -> done, and back from leased to
/// queued; done is for ever, and a queued tile may become done by a late result. Frames cost memory only
/// from their first touch until they are done. Not thread-safe.
class JobQueue {
 public:
  JobQueue(int frames, int columns, int rows);

  int64_t queued() const { return queued_; }
  int64_t remaining() const { return remaining_; }  ///< Queued and leased.
  int tiles_per_frame() const { return int(order_.size()); }
  int frame_count() const { return int(frames_.size()); }

  bool Contains(int frame, uint32_t tile) const;
  bool IsDone(int frame, uint32_t tile) const;
  int DoneInFrame(int frame) const;
  /// The lease that holds the tile, 0 where none does.
  LeaseId Holder(int frame, uint32_t tile) const;

  /// False if it was done before. The tile's lease, if any, no longer holds it.
  bool MarkDone(int frame, uint32_t tile);
  void MarkFrameDone(int frame);
  /// Queues done tiles again, whose pixels have been lost.
  void Reopen(int frame, const std::vector<uint32_t>& tiles);

  /// The frame that `worker` should render next: one of `held` (most recent first) with queued tiles, else
  /// one that nobody has begun, else the one with most queued tiles a worker. None: nothing is queued.
  std::optional<int> ChooseFrame(const std::deque<int>& held, WorkerId worker) const;

  /// Takes up to `count` queued tiles of the frame for `lease`: first those that came back, then along the
  /// Hilbert curve. A suspect tile comes alone. Never empty if the frame has queued tiles.
  std::vector<uint32_t> Take(int frame, int count, WorkerId worker, LeaseId lease);
  /// Puts a tile that `lease` holds back into the queue. Nothing happens where it holds it no longer.
  void PutBack(int frame, uint32_t tile, LeaseId lease);
  /// The worker has nothing to do with the frame any more.
  void Leave(int frame, WorkerId worker);

  /// Counts a failure of the tile and returns how many there have been.
  int CountFailure(int frame, uint32_t tile);
  /// Notes that the worker ended while it rendered the tile, which from now on is leased alone; returns how
  /// many different workers have.
  int CountDeath(int frame, uint32_t tile, const std::string& worker_uuid);

 private:
  struct Trouble {
    int failures = 0;
    absl::flat_hash_set<std::string> dead_workers;
  };
  struct Frame {
    std::vector<bool> done;
    std::deque<uint32_t> returned;  ///< May hold tiles that are done by now.
    size_t cursor = 0;              ///< Into order_: what lies behind has not been handed out yet.
    int queued = 0, done_count = 0;
    absl::flat_hash_map<uint32_t, LeaseId> leased;
    absl::flat_hash_map<uint32_t, Trouble> trouble;
    absl::flat_hash_set<WorkerId> workers;
  };
  enum class Phase : uint8_t { kUntouched, kActive, kDone };
  struct Slot {
    Phase phase = Phase::kUntouched;
    std::unique_ptr<Frame> frame;  ///< Where kActive.
  };

  Frame& Touch(int frame);
  Frame* Active(int frame) const;
  void Finish(int frame);

  std::vector<uint32_t> order_;
  std::vector<Slot> frames_;
  std::set<int> hungry_;             ///< Active frames with queued tiles.
  mutable int first_untouched_ = 0;  ///< No frame before it is untouched.
  int64_t queued_ = 0, remaining_ = 0;
};

}  // namespace shutterline::server
