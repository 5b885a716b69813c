#include "worker/loop/render_loop.h"

#include <absl/cleanup/cleanup.h>
#include <absl/strings/str_cat.h>
#include <spdlog/spdlog.h>

#include <bit>
#include <cstring>
#include <exception>
#include <utility>

#include "common/base/log.h"
#include "common/base/status_macros.h"
#include "common/job/output_channels.h"
#include "common/job/tile.h"

namespace shutterline::worker {

static_assert(std::endian::native == std::endian::little, "tiles travel as little-endian floats");

RenderLoop::RenderLoop(int threads, LeaseBoard& board, ResultBuffer& results, FrameCache& frames,
                       OpenScene open_scene, const Clock& clock, RenderingTable* table)
    : board_(board),
      results_(results),
      frames_(frames),
      open_scene_(std::move(open_scene)),
      clock_(clock),
      table_(table) {
  for (int i = 0; i < threads; ++i) threads_.emplace_back([this, i] { Run(size_t(i)); });
}

RenderLoop::~RenderLoop() {
  board_.Close();
  results_.Close();
  for (std::thread& thread : threads_) thread.join();
}

void RenderLoop::Run(size_t thread) {
  // Room first: a thread that holds a tile must be able to finish it.
  while (results_.WaitForRoom()) {
    const std::optional<TileTask> task = board_.Take();
    if (!task) return;
    if (task->job->forgotten) {
      board_.FrameReady(*task, false);
    } else {
      if (task->send_at_once) results_.Hurry();
      if (table_ != nullptr) table_->Begin(thread, task->job->id, task->frame, task->tile);
      spdlog::debug("tile begins job={} frame={} tile={} lease={}", LogValue(task->job->id), task->frame,
                    task->tile, task->lease_id);
      TileResult result = RenderTile(*task);
      if (table_ != nullptr) table_->End(thread);
      // In this order: a worker that drains sees the tile on the board or among the results, always.
      if (!task->job->forgotten) results_.Add(std::move(result));
    }
    if (board_.Rendered(*task) || task->send_at_once) results_.Hurry();
  }
}

TileResult RenderLoop::RenderTile(const TileTask& task) {
  TileResult result;
  result.task = task;
  const absl::Duration start = clock_.Monotonic();
  try {
    result.status = RenderPixels(task, result);
  } catch (const std::exception& e) {
    result.status = absl::InternalError(absl::StrCat("exception: ", e.what()));
  } catch (...) {
    result.status = absl::InternalError("unknown exception");
  }
  result.render_time = clock_.Monotonic() - start;
  ++(result.status.ok() ? tiles_rendered_ : tiles_failed_);
  if (!result.status.ok()) {
    result.pixels.clear();
    spdlog::warn("tile failed job={} frame={} tile={} lease={} reason={}", LogValue(task.job->id), task.frame,
                 task.tile, task.lease_id, LogValue(result.status.ToString()));
  } else {
    spdlog::debug("tile rendered job={} frame={} tile={} lease={} ms={:.1f}", LogValue(task.job->id),
                  task.frame, task.tile, task.lease_id, absl::ToDoubleMilliseconds(result.render_time));
  }
  return result;
}

absl::StatusOr<std::shared_ptr<const FrameRenderer>> RenderLoop::FrameOf(const TileTask& task) const {
  bool ok = false;
  const absl::Cleanup ready = [&] { board_.FrameReady(task, ok); };
  const WorkerJob& job = *task.job;
  SL_RETURN_IF_ERROR(job.status);
  const TileGrid grid{job.settings.width, job.settings.height};
  if (int64_t{task.tile} >= int64_t{grid.Count()}) {
    return absl::InvalidArgumentError(
        absl::StrCat("tile ", task.tile, " does not exist: the frame has ", grid.Count()));
  }
  auto frame = frames_.Get(job.scene_key, task.frame, job.settings, [&] { return open_scene_(job.scene); });
  ok = frame.ok();
  return frame;
}

absl::Status RenderLoop::RenderPixels(const TileTask& task, TileResult& result) const {
  const WorkerJob& job = *task.job;
  SL_ASSIGN_OR_RETURN(const std::shared_ptr<const FrameRenderer> frame, FrameOf(task));
  const TileGrid grid{job.settings.width, job.settings.height};
  const TileRect rect = grid.Rect(int(task.tile));
  std::vector<float> pixels(size_t(rect.Area()) * size_t(OutputChannelCount(job.settings)));
  SL_RETURN_IF_ERROR(frame->Render(rect, pixels, result.stats));
  result.pixels.resize(pixels.size() * sizeof(float));
  std::memcpy(result.pixels.data(), pixels.data(), result.pixels.size());
  return absl::OkStatus();
}

}  // namespace shutterline::worker
