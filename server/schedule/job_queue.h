#pragma once

#include <absl/container/flat_hash_map.h>
#include <absl/container/flat_hash_set.h>
#include <absl/functional/function_ref.h>
#include <absl/time/time.h>

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "common/job/tile_order.h"
#include "server/schedule/lease.h"
#include "server/schedule/tile_trouble.h"

namespace shutterline::server {

/// What went wrong with a tile that is not done.
struct TroubleLog {
  std::vector<TileTrouble> evidence;           ///< The latest, oldest first.
  int failures = 0;                            ///< Reported.
  int deaths = 0;                              ///< Of workers that rendered it.
  absl::flat_hash_set<std::string> failed_by;  ///< UUIDs of workers that reported a failure or died.
  /// UUIDs of workers that ended while they rendered it, and the processes (boot ids) that did.
  absl::flat_hash_map<std::string, std::string> dead;

  /// Leased alone: it may take workers with it.
  bool suspect() const { return !dead.empty(); }
};

/// The leases that hold a tile; 0: none. A second one is a copy (speculation).
struct Holders {
  LeaseId first = 0, second = 0;
  bool Has(LeaseId lease) const { return lease != 0 && (first == lease || second == lease); }
};

/// The tiles of one job: each is queued, leased (once or twice), done or quarantined. Queued -> leased ->
/// done, and back from leased to queued; quarantined tiles wait for Release; done is for ever, and a queued
/// tile may become done by a late result. Frames cost memory only from their first touch until they are done.
/// Not thread-safe.
class JobQueue {
 public:
  JobQueue(int frames, int columns, int rows, TileOrder order = TileOrder::kHilbert);

  int64_t queued() const { return queued_; }
  int64_t remaining() const { return remaining_; }  ///< Queued and leased.
  int64_t quarantined() const { return quarantined_; }
  int tiles_per_frame() const { return int(order_.size()); }
  int frame_count() const { return int(frames_.size()); }

  bool Contains(int frame, uint32_t tile) const;
  bool IsDone(int frame, uint32_t tile) const;
  bool IsQuarantined(int frame, uint32_t tile) const;
  int DoneInFrame(int frame) const;
  Holders HoldersOf(int frame, uint32_t tile) const;

  /// False if it was done before, or is quarantined. The tile's leases, if any, no longer hold it.
  bool MarkDone(int frame, uint32_t tile);
  void MarkFrameDone(int frame);
  /// Queues done tiles again, whose pixels have been lost.
  void Reopen(int frame, const std::vector<uint32_t>& tiles);
  /// Takes a tile that is neither done nor leased out of the queue.
  void Quarantine(int frame, uint32_t tile);
  /// Queues all quarantined tiles again, their troubles forgotten; returns them as (frame, tile).
  std::vector<std::pair<int, uint32_t>> Release();

  /// Whether a worker is not to be given a tile with such troubles.
  using Refuses = absl::FunctionRef<bool(const TroubleLog&)>;

  /// The frame that `worker` should render next: one of `held` (most recent first) with tiles that it does
  /// not refuse, else one that nobody has begun, else the one with most queued tiles a worker. None: it
  /// refuses whatever is queued, or nothing is.
  std::optional<int> ChooseFrame(const std::deque<int>& held, WorkerId worker, Refuses refuses) const;

  /// Takes up to `count` queued tiles of the frame for `lease`: first those that came back, then in the job's
  /// order. A suspect tile comes alone. Never empty for a frame that ChooseFrame has named.
  struct Taken {
    std::vector<uint32_t> tiles;
    bool came_back = false;  ///< Some of them have been leased before, or their pixels were lost.
  };
  Taken Take(int frame, int count, WorkerId worker, LeaseId lease, Refuses refuses);
  /// Takes those of `tiles` that are queued, suspect ones left out.
  std::vector<uint32_t> TakeThese(int frame, const std::vector<uint32_t>& tiles, WorkerId worker,
                                  LeaseId lease);
  /// Makes `lease` the second holder of a tile that is leased once.
  void AddCopy(int frame, uint32_t tile, WorkerId worker, LeaseId lease);
  /// `lease` holds the tile no longer; it is queued unless another does. Nothing happens where it held it
  /// not.
  void PutBack(int frame, uint32_t tile, LeaseId lease);
  /// The worker has nothing to do with the frame any more.
  void Leave(int frame, WorkerId worker);

  /// Null: nothing has gone wrong with the tile.
  const TroubleLog* TroublesOf(int frame, uint32_t tile) const;
  /// Notes a trouble with a tile that is not done.
  const TroubleLog& AddTrouble(int frame, uint32_t tile, TileTrouble trouble);
  /// Whether the tile is held for the end of this process.
  bool Blames(int frame, uint32_t tile, const std::string& worker_uuid, const std::string& boot_id) const;
  /// What is known by now of a process that ended goes to the troubles that it is held for. Tiles for which
  /// `acquits` holds are held for it no longer, unless they are quarantined.
  void Testify(const std::string& worker_uuid, const ProcessEnd& end,
               absl::FunctionRef<bool(int frame, uint32_t tile)> acquits);
  /// The process lives: it did not end while it rendered anything.
  void Acquit(const std::string& worker_uuid, const std::string& boot_id);

 private:
  struct Frame {
    std::vector<bool> done;
    std::deque<uint32_t> returned;  ///< May hold tiles that are not queued by now.
    size_t cursor = 0;              ///< Into order_: what lies behind has not been handed out yet.
    int queued = 0, done_count = 0;
    absl::flat_hash_map<uint32_t, Holders> leased;
    absl::flat_hash_map<uint32_t, TroubleLog> troubles;
    absl::flat_hash_set<uint32_t> quarantined;
    absl::flat_hash_set<WorkerId> workers;

    bool IsQueued(uint32_t tile) const {
      return !done[tile] && !leased.contains(tile) && !quarantined.contains(tile);
    }
  };
  enum class Phase : uint8_t { kUntouched, kActive, kDone };
  /// A process that ended did not do so because of the tile, as it seems now.
  static void Acquit(TroubleLog& log, const std::string& worker_uuid, const std::string& boot_id);

  struct Slot {
    Phase phase = Phase::kUntouched;
    std::unique_ptr<Frame> frame;  ///< Where kActive.
  };

  Frame& Touch(int frame);
  Frame* Active(int frame) const;
  void Finish(int frame);
  /// Takes a queued tile out of the counts, and puts it back into them.
  void Unqueue(int frame, Frame& f);
  void Requeue(int frame, Frame& f, uint32_t tile, bool first);
  /// Whether a queued tile of the frame is not refused.
  bool Offers(const Frame& f, Refuses refuses) const;

  std::vector<uint32_t> order_;
  std::vector<Slot> frames_;
  std::set<int> hungry_;             ///< Active frames with queued tiles.
  mutable int first_untouched_ = 0;  ///< No frame before it is untouched.
  int64_t queued_ = 0, remaining_ = 0, quarantined_ = 0;
};

}  // namespace shutterline::server
