#pragma once

#include <absl/functional/function_ref.h>

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "common/job/tile.h"
#include "server/assets/asset_store.h"
#include "server/control/events.h"
#include "server/jobs/job_store.h"

namespace shutterline::server {

/// A job in memory: what is on disk, how far its frames are, and in which order things changed. The farm's
/// mutex guards it.
class LiveJob {
 public:
  /// `seq` numbers the first change, that the job is there.
  LiveJob(const JobRecord& record, uint64_t seq);

  uint64_t key() const { return snapshot_.key; }
  const std::string& id() const { return snapshot_.id; }
  const std::shared_ptr<const JobSpec>& spec() const { return snapshot_.spec; }
  JobState state() const { return snapshot_.state; }
  TileGrid grid() const { return {spec()->render.width, spec()->render.height}; }
  int frame_count() const { return int(frames_.size()); }
  /// As clients see it, but for the number of workers.
  const JobSnapshot& snapshot() const { return snapshot_; }
  FrameSnapshot Frame(int index) const;
  uint64_t seq() const { return seq_; }  ///< Of the job's own last change.
  bool AllFinished() const { return snapshot_.frames_finished == snapshot_.frames_total; }
  /// Every tile of the frame is done or quarantined.
  bool Settled(int index) const;
  /// Tiles of the frame that are quarantined.
  std::set<uint32_t> Missing(int index) const;
  /// By frame and tile.
  const std::map<std::pair<int, uint32_t>, QuarantinedTile>& quarantined() const { return quarantined_; }

  /// Each is a change with its number; numbers grow.
  /// `stats`: what the tile took; zeros where that is not known.
  void TileDone(int index, const RenderStats& stats, uint64_t seq, uint64_t frame_seq);
  /// What the tiles took stays counted: it was spent.
  void TilesLost(int index, int count, uint64_t seq, uint64_t frame_seq);
  /// `frame` is what the store has of it, statistics included.
  void FrameFinished(int index, const FinishedFrame& frame, uint64_t seq, uint64_t frame_seq);
  void CountMismatch(uint64_t seq);
  void TileQuarantined(int index, const QuarantinedTile& tile, uint64_t seq, uint64_t frame_seq);
  /// Notes the end of a worker's process in the evidence of quarantined tiles; returns those, by frame's
  /// index and tile, that were told something new.
  std::vector<std::pair<int, uint32_t>> Testify(const std::string& worker_uuid, const ProcessEnd& end);
  /// No tile is quarantined any more; frames that lacked tiles are not finished. `next_seq` numbers changes.
  void ReleaseQuarantined(absl::FunctionRef<uint64_t()> next_seq);
  void SetPaused(bool paused, uint64_t seq);
  void SetPriority(int priority, uint64_t seq);
  void WaitFor(const std::string& job_id, uint64_t seq);
  /// False where it did not wait for that job.
  bool WaitsNoMoreFor(const std::string& job_id, uint64_t seq);
  void End(JobState state, const std::string& error, absl::Time now, uint64_t seq);

  /// The first change after `seq`, as things are now.
  std::optional<JobChange> NextChange(uint64_t seq) const;

  bool ending = false;  ///< Being ended: nothing of it counts any more.
  bool dirty = false;   ///< Changed since watchers were last told.
  std::set<JobWatcher*> watchers;
  std::shared_ptr<const BlobPins> blobs;  ///< Its scene's, until it ends.

 private:
  struct FrameProgress {
    int tiles_done = 0;
    bool finished = false;
    uint64_t seq = 0;  ///< Of its last change; 0: none.
    Digest digest;
    uint64_t size = 0;
    RenderStats stats;
    int missing = 0;
  };
  static constexpr int kJobItself = -1;

  void Changed(uint64_t& last, uint64_t seq, int what);

  JobSnapshot snapshot_;
  std::vector<FrameProgress> frames_;
  std::map<std::pair<int, uint32_t>, QuarantinedTile> quarantined_;
  uint64_t seq_ = 0;
  std::map<uint64_t, int> changes_;  ///< What changed last at this number: a frame, or the job itself.
};

}  // namespace shutterline::server
