#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <thread>
#include <vector>

#include "common/base/clock.h"
#include "worker/frames/frame_cache.h"
#include "worker/loop/lease_board.h"
#include "worker/loop/result_buffer.h"
#include "worker/supervise/rendering_table.h"

namespace shutterline::worker {

/// Makes a job's scene readable; called when it has to be imported.
using OpenScene =
    std::function<absl::StatusOr<std::unique_ptr<engine::AssetSource>>(const SceneManifest& scene)>;

/// The threads that render: each takes a tile from the board, gets its frame from the cache, renders and
/// hands the result on. Whatever fails, import and exceptions included, becomes the tile's result; no
/// input ends a thread. Between tiles a job that has ended is let go at once.
class RenderLoop {
 public:
  /// Starts `threads` threads, which say in `table`, unless it is null, what they are at. Everything handed
  /// in must outlive this.
  RenderLoop(int threads, LeaseBoard& board, ResultBuffer& results, FrameCache& frames, OpenScene open_scene,
             const Clock& clock, RenderingTable* table = nullptr);
  /// Closes board and results and waits for the tiles that are being rendered.
  ~RenderLoop();

  int64_t tiles_rendered() const { return tiles_rendered_; }
  int64_t tiles_failed() const { return tiles_failed_; }

 private:
  void Run(size_t thread);
  TileResult RenderTile(const TileTask& task);
  absl::StatusOr<std::shared_ptr<const FrameRenderer>> FrameOf(const TileTask& task) const;
  absl::Status RenderPixels(const TileTask& task, TileResult& result) const;

  LeaseBoard& board_;
  ResultBuffer& results_;
  FrameCache& frames_;
  const OpenScene open_scene_;
  const Clock& clock_;
  RenderingTable* const table_;
  std::atomic<int64_t> tiles_rendered_ = 0;
  std::atomic<int64_t> tiles_failed_ = 0;
  std::vector<std::thread> threads_;
};

}  // namespace shutterline::worker
