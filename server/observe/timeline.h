#pragma once

#include <absl/base/thread_annotations.h>
#include <absl/container/flat_hash_map.h>
#include <absl/synchronization/mutex.h>
#include <absl/time/time.h>

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/control/observer.h"

namespace shutterline::server {

/// What happened to a frame, in the order in which its tiles came. Times are monotonic.
struct FrameTimeline {
  struct Worker {
    std::string uuid, name;
  };
  struct Tile {
    uint32_t tile = 0;
    uint32_t worker = 0;      ///< Index into workers.
    LeaseId lease = 0;        ///< 0: the grant was not seen.
    absl::Duration granted;   ///< Of a grant that was not seen: when rendering must have begun.
    absl::Duration received;  ///< By the coordinator.
    absl::Duration durable;
    absl::Duration render_time;  ///< As the worker measured it.
  };
  uint64_t id = 0;  ///< Another one, once the frame was dropped and begun anew.
  std::vector<Worker> workers;
  std::vector<Tile> tiles;
  size_t skipped = 0;  ///< Tiles before tiles[0] that were not asked for.
  /// Writing the file: from, to; none until it is written.
  std::optional<std::pair<absl::Duration, absl::Duration>> assembly;
};

/// Keeps the timelines of the latest frames: for traces, for the map of tile times, and to tell which tiles
/// have come since. Lives in memory alone and is bounded: beyond `max_entries` tiles (granted or come, about
/// 100 bytes each) the frames that began first are dropped whole, and of a frame larger than that the rest
/// is left out. Thread-safe.
class Timeline final : public FarmObserver {
 public:
  explicit Timeline(size_t max_entries = size_t{1} << 18) : max_entries_(max_entries) {}

  void OnGranted(const Granted& seen) override;
  void OnTileStored(const TileStored& seen) override;
  void OnFrameWritten(const FrameWritten& seen) override;
  void OnJobEnded(absl::string_view job_id, JobState state) override;

  /// The job's frames that are kept, by number.
  std::vector<int> Frames(const std::string& job_id) const;
  /// The frame, without its first `skip` tiles. None where it is not kept.
  std::optional<FrameTimeline> Find(const std::string& job_id, int frame, size_t skip = 0) const;
  size_t entries() const;

 private:
  using Key = std::pair<std::string, int>;
  struct Grant {
    LeaseId lease = 0;
    absl::Duration at;
  };
  struct Frame {
    FrameTimeline timeline;
    absl::flat_hash_map<WorkerId, uint32_t> workers;
    absl::flat_hash_map<std::pair<uint32_t, WorkerId>, Grant> open;
  };

  Frame& Touch(const Key& key) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  bool MakeRoom(const Key& key) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void CloseGrants(Frame& frame) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  static uint32_t WorkerIndex(Frame& frame, WorkerId worker, absl::string_view uuid, absl::string_view name);

  const size_t max_entries_;
  mutable absl::Mutex mutex_;
  std::map<Key, Frame> frames_ ABSL_GUARDED_BY(mutex_);
  std::deque<Key> begun_ ABSL_GUARDED_BY(mutex_);  ///< Longest first.
  size_t entries_ ABSL_GUARDED_BY(mutex_) = 0;
  uint64_t next_id_ ABSL_GUARDED_BY(mutex_) = 1;
};

}  // namespace shutterline::server
