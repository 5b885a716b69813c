#pragma once

#include <absl/status/statusor.h>

#include <list>
#include <memory>
#include <mutex>
#include <utility>

#include "common/asset/digest.h"
#include "common/image/exr.h"
#include "common/job/job_spec.h"
#include "server/assets/asset_store.h"
#include "worker/engine/scene/camera_track.h"
#include "worker/engine/scene/scene.h"

namespace shutterline::server {

/// Where the cameras of jobs are, frame by frame: what goes into the headers of their files. A scene is
/// imported for it once, and the tracks of the latest jobs are kept. Thread-safe.
class FrameCameras {
 public:
  /// Keeps what the frames of a job will want, of its scene that has just been imported.
  absl::Status Keep(const JobSpec& spec, const engine::Scene& scene);

  /// Of a job's frame, at mid-shutter.
  absl::StatusOr<CameraMatrices> At(const JobSpec& spec, AssetStore& assets, int frame);

 private:
  using Track = std::shared_ptr<const engine::CameraTrack>;
  static constexpr size_t kMost = 16;

  Track Find(const Digest& key);
  void Add(const Digest& key, Track track);

  std::mutex mutex_;
  std::list<std::pair<Digest, Track>> tracks_;  ///< By PictureKey, the latest first.
};

}  // namespace shutterline::server
