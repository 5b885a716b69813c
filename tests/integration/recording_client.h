#pragma once

#include <absl/base/thread_annotations.h>
#include <absl/synchronization/mutex.h>

#include <atomic>
#include <set>
#include <string>
#include <thread>
#include <tuple>

#include "shutterline/v1/jobs.grpc.pb.h"
#include "shutterline/v1/workers.grpc.pb.h"

namespace shutterline {

/// Submits jobs and renders their tiles, with synthetic pixels, as fast as a coordinator takes them, and
/// keeps a record of what has been acknowledged, while that coordinator is killed and started again.
class RecordingClient {
 public:
  using Tile = std::tuple<std::string, int, uint32_t>;  ///< Job, frame, tile.

  /// Jobs are copies of `spec`, at most `most_jobs`. Starts at once.
  RecordingClient(std::string address, v1::JobSpec spec, size_t most_jobs);
  /// Stops; the coordinator must be gone, or else a stream may be waited for.
  ~RecordingClient();

  /// No more jobs: those that are there come to their end.
  void StopSubmitting() { submitting_ = false; }
  void Stop();

  std::set<std::string> AcknowledgedJobs() const;
  std::set<Tile> AcknowledgedTiles() const;

  /// Sends these tiles again to the running coordinator. Those that it does not know are returned.
  std::set<Tile> Unknown(const std::set<Tile>& tiles) const;

 private:
  void Submit();
  void Render();
  void Serve(v1::Workers::Stub& stub);
  v1::TileResult ResultOf(const Tile& tile) const;
  std::shared_ptr<grpc::Channel> Dial() const;

  const std::string address_;
  const v1::JobSpec spec_;
  const size_t most_jobs_;
  std::atomic<bool> submitting_ = true, stopping_ = false;
  mutable absl::Mutex mutex_;
  std::set<std::string> jobs_ ABSL_GUARDED_BY(mutex_);
  std::set<Tile> tiles_ ABSL_GUARDED_BY(mutex_);
  std::thread submitter_, worker_;
};

}  // namespace shutterline
