#pragma once

#include <absl/status/statusor.h>

#include <filesystem>
#include <memory>

#include "server/coordinator.h"
#include "worker/engine/scene/scene_shelf.h"
#include "worker/frames/frame_renderer.h"
#include "worker/worker.h"

namespace grpc {
class Channel;
}

namespace shutterline::client {

/// A coordinator and a worker inside this process, over a temporary folder: what `render` runs on. Jobs go
/// through the same services, queues and journals as on a farm; only the network is missing. Thread-safe.
class InProcessFarm {
 public:
  /// Starts both; `threads` render, 0: one for each processor, with a shading cache of so many bytes, 0: with
  /// none. Nothing is listened on, so nobody else can
  /// reach it. The folder is made in the system's place for temporary files ($TMPDIR).
  static absl::StatusOr<std::unique_ptr<InProcessFarm>> Start(int threads, uint64_t shading_cache_bytes);
  /// Stops the worker (waiting for the tiles that it is at), then the coordinator, and removes the folder.
  ~InProcessFarm();
  InProcessFarm(const InProcessFarm&) = delete;
  InProcessFarm& operator=(const InProcessFarm&) = delete;

  std::shared_ptr<grpc::Channel> Channel();
  const worker::Worker& worker() const { return *worker_; }
  const std::filesystem::path& folder() const { return folder_; }

 private:
  InProcessFarm() = default;

  engine::SceneShelf shelf_;
  std::filesystem::path folder_;
  std::unique_ptr<worker::FrameRendererFactory> engine_;
  std::unique_ptr<server::Coordinator> coordinator_;
  std::unique_ptr<worker::Worker> worker_;
};

}  // namespace shutterline::client
