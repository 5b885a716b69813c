#pragma once

#include <absl/base/thread_annotations.h>
#include <absl/container/flat_hash_map.h>
#include <absl/synchronization/mutex.h>

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "common/asset/digest.h"
#include "common/image/exr_blocks.h"
#include "common/job/job_spec.h"
#include "server/assemble/tile_journal.h"

namespace shutterline::server {

/// How frames of a job are encoded.
ExrBlockEncoder BlockEncoderOf(const JobSpec& spec);

/// Tiles of unfinished frames as their EXR will hold them, compressed by a thread of its own while others are
/// still being rendered, so that little is left to do once a frame has all of them.
///
///     Add*  (Take | DropJob)
///
/// A cache and no more: nothing here is durable, a tile that is not here is encoded from the journal when its
/// frame is put together, and what is here counts only as far as the journal has the same pixels. Memory is
/// bounded: what comes when there is no room is passed over. Thread-safe.
class FrameBlocks {
 public:
  using FrameKey = TileJournal::FrameKey;
  struct Options {
    uint64_t max_block_bytes = uint64_t{256} << 20;   ///< Of all blocks and frames; 0: none are made.
    uint64_t max_waiting_bytes = uint64_t{32} << 20;  ///< Of pixels that wait for the thread.
  };
  struct Block {
    Digest pixels;  ///< What it was made of.
    std::string bytes;
  };
  using Blocks = absl::flat_hash_map<uint32_t, Block>;  ///< By tile.

  explicit FrameBlocks(const Options& options);
  /// Ends the thread; what waits is dropped.
  ~FrameBlocks();
  FrameBlocks(const FrameBlocks&) = delete;
  FrameBlocks& operator=(const FrameBlocks&) = delete;

  /// A tile of the journal: `pixels`, whose SHA-256 is `digest`. Does not wait.
  void Add(const FrameKey& frame, const JobSpec& spec, uint32_t tile, const Digest& digest,
           std::string pixels);
  /// What there is of a frame, which is forgotten here.
  Blocks Take(const FrameKey& frame);
  void DropJob(uint64_t job);

  /// Returns when nothing waits any more. For tests.
  void WaitUntilIdle();
  struct Totals {
    uint64_t block_bytes = 0;  ///< With what their places take, about.
    uint64_t waiting_bytes = 0;
    size_t frames = 0;
  };
  Totals totals() const;

 private:
  struct Frame {
    explicit Frame(const JobSpec& spec) : encoder(BlockEncoderOf(spec)), render(spec.render) {}
    const ExrBlockEncoder encoder;
    const RenderSettings render;
    Blocks blocks;       ///< Guarded by FrameBlocks::mutex_.
    uint64_t bytes = 0;  ///< Likewise: what they count for.
  };
  struct Task {
    FrameKey key;
    std::shared_ptr<Frame> frame;
    uint32_t tile = 0;
    Digest digest;
    std::string pixels;
  };
  struct Erased {
    std::vector<std::shared_ptr<Frame>> frames;
    std::vector<Task> tasks;
  };
  void Work();
  static absl::StatusOr<std::string> Encode(const Task& task);
  /// Enters a block, if the frame is still there and has room.
  void Keep(const Task& task, std::string block) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  /// Forgets frames of [from, to).
  Erased Erase(const FrameKey& from, const FrameKey& to) ABSL_LOCKS_EXCLUDED(mutex_);

  const Options options_;
  mutable absl::Mutex mutex_;
  std::map<FrameKey, std::shared_ptr<Frame>> frames_ ABSL_GUARDED_BY(mutex_);
  std::deque<Task> waiting_ ABSL_GUARDED_BY(mutex_);
  uint64_t block_bytes_ ABSL_GUARDED_BY(mutex_) = 0;
  uint64_t waiting_bytes_ ABSL_GUARDED_BY(mutex_) = 0;
  bool working_ ABSL_GUARDED_BY(mutex_) = false;
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  std::thread thread_;
};

}  // namespace shutterline::server
