#pragma once

#include <absl/status/status.h>
#include <absl/time/time.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>

#include "common/asset/digest.h"
#include "common/job/job_spec.h"
#include "common/job/render_settings.h"
#include "common/job/render_stats.h"

namespace shutterline::worker {

/// A job as a worker knows it. Immutable but for `forgotten` and `imported`.
struct WorkerJob {
  std::string id;
  absl::Status status;  ///< Not OK: the coordinator's description of it made no sense; its tiles fail so.
  SceneManifest scene;
  RenderSettings settings;
  Digest scene_key;  ///< Equal for scenes of equal files.
  /// The job has ended: do not start its tiles, do not send its results.
  std::atomic<bool> forgotten = false;
  /// Its scene has been imported here: what its frames wait for is not that.
  mutable std::atomic<bool> imported = false;
};

/// One tile that is to be rendered.
struct TileTask {
  std::shared_ptr<const WorkerJob> job;
  uint64_t ticket = 0;    ///< The board's own number of the lease, which no other has.
  uint64_t lease_id = 0;  ///< When it was granted. Unique within a session; sessions may use numbers again.
  uint64_t session = 0;   ///< Number of the board's session in which it was granted.
  int frame = 0;
  uint32_t tile = 0;
  bool send_at_once = false;  ///< What is finished is sent before it begins, and its result as it comes.
};

/// One tile that has been rendered, or could not be.
struct TileResult {
  TileTask task;
  absl::Status status;
  std::string pixels;  ///< As TileIntegrator writes them, little-endian; empty on failure.
  absl::Duration render_time;
  RenderStats stats;  ///< Of this tile.

  /// Roughly what it takes of memory, and a little more than what it takes in a message.
  size_t Bytes() const {
    // A number of the statistics takes at most 12 bytes of a message.
    return pixels.size() + status.message().size() + task.job->id.size() + 2 * sizeof(RenderStats) + 64;
  }
};

}  // namespace shutterline::worker
