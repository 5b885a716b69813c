#pragma once

#include <absl/status/statusor.h>
#include <absl/time/time.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "common/base/clock.h"
#include "worker/frames/frame_renderer.h"
#include "worker/supervise/rendering_table.h"
#include "worker/supervise/worker_exit.h"

namespace grpc {
class Channel;
}

namespace shutterline::engine {
class SceneShelf;
}

namespace shutterline::worker {

struct WorkerOptions {
  // --- Who it is ---------------------------------------------------------------------------------
  std::string name;               ///< For people. Empty: "HOST:PID".
  std::string uuid;               ///< Empty: a new one.
  std::string boot_id;            ///< Of this process. Empty: a new one.
  std::string build_id;           ///< Empty: this build's. Coordinators refuse others than their own.
  std::vector<WorkerExit> exits;  ///< How earlier processes of this worker ended, the latest last: at most 4.

  // --- What it may use ---------------------------------------------------------------------------
  int threads = 0;                            ///< That render; 0: one for each processor.
  std::filesystem::path cache_dir;            ///< Where blobs are kept; made if missing.
  uint64_t cache_bytes = uint64_t{10} << 30;  ///< Of blobs on disk.
  size_t max_scenes = 2;                      ///< Imported and kept.
  size_t max_frames = 4;                      ///< Made ready and kept.
  /// Results that the coordinator has not acknowledged; beyond it rendering pauses.
  size_t max_result_bytes = size_t{64} << 20;
  /// What the factory lets the import of a scene, and the making of a frame, take. A scene that took too long
  /// is not tried again before as much time has passed.
  absl::Duration scene_time = absl::InfiniteDuration();
  engine::SceneShelf* shelf = nullptr;  ///< As FrameCacheOptions has it: of a coordinator in this process.

  // --- How it behaves ----------------------------------------------------------------------------
  absl::Duration backoff_initial = absl::Milliseconds(100);
  absl::Duration backoff_max = absl::Seconds(10);
  /// How long a draining worker tries to deliver its results to a coordinator that is away.
  absl::Duration drain_patience = absl::Seconds(30);
  RenderingTable* table =
      nullptr;  ///< Where threads say what they are at; may be null, or outlives the worker.
};

/// "HOST:PID": what a worker without a name is called.
std::string DefaultWorkerName();
/// As many threads as options ask for, 0 being one for each processor.
int ThreadsOf(const WorkerOptions& options);

struct WorkerCounts {
  int64_t tiles_rendered = 0;
  int64_t tiles_failed = 0;
  int registrations = 0;
};

/// A whole worker: registers with the coordinator behind a channel, leases tiles, renders them with all
/// its threads and delivers them, until it is told to leave. The same in a process of its own and inside
/// the client's, over an in-process channel.
///
///     EngineFrameRendererFactory engine;
///     SL_ASSIGN_OR_RETURN(auto worker, worker::Worker::Start(channel, options, engine));
///     worker->Drain();
///     absl::Status end = worker->Wait();
///
/// Thread-safe.
class Worker {
 public:
  /// Starts all threads; does not wait for the coordinator. INVALID_ARGUMENT for options that make no
  /// sense, or the reason why the cache folder cannot be used. `factory` and `clock` must outlive it.
  static absl::StatusOr<std::unique_ptr<Worker>> Start(std::shared_ptr<grpc::Channel> channel,
                                                       const WorkerOptions& options,
                                                       FrameRendererFactory& factory,
                                                       const Clock& clock = Clock::System());
  /// Stop. Tiles that are being rendered are waited for: the engine cannot be interrupted within one.
  ~Worker();
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  /// Finish and deliver what is leased, then leave. Returns at once.
  void Drain();
  /// Leave now. Tiles under way are lost to us, and rendered by others.
  void Stop();
  /// Blocks until the worker has left and says why: OK after Drain, CANCELLED after Stop, UNAVAILABLE where
  /// a drained worker could not deliver, otherwise the error that made it give up (another build, no
  /// permission).
  absl::Status Wait();

  WorkerCounts counts() const;
  int threads() const;

 private:
  struct Impl;
  explicit Worker(std::unique_ptr<Impl> impl);
  const std::unique_ptr<Impl> impl_;
};

}  // namespace shutterline::worker
