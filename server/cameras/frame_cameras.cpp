#include "server/cameras/frame_cameras.h"

#include <algorithm>

#include "common/base/status_macros.h"
#include "server/assets/blob_scene_source.h"
#include "worker/engine/scene/gltf_import.h"

namespace shutterline::server {

absl::Status FrameCameras::Keep(const JobSpec& spec, const engine::Scene& scene) {
  SL_ASSIGN_OR_RETURN(engine::CameraTrack track, engine::CameraTrack::Make(scene, spec.render));
  Add(PictureKey(spec.scene, spec.render), std::make_shared<const engine::CameraTrack>(std::move(track)));
  return absl::OkStatus();
}

absl::StatusOr<CameraMatrices> FrameCameras::At(const JobSpec& spec, AssetStore& assets, int frame) {
  const Digest key = PictureKey(spec.scene, spec.render);
  Track track = Find(key);
  if (track == nullptr) {
    // The coordinator has been restarted since the job was submitted, or many others were.
    SL_ASSIGN_OR_RETURN(const std::shared_ptr<const engine::Scene> scene,
                        engine::ImportGltf(BlobSceneSource(spec.scene, assets)));
    SL_RETURN_IF_ERROR(Keep(spec, *scene));
    track = Find(key);
    if (track == nullptr) return absl::InternalError("the camera's track is not there");
  }
  return track->At(frame);
}

FrameCameras::Track FrameCameras::Find(const Digest& key) {
  const std::lock_guard lock(mutex_);
  const auto found =
      std::find_if(tracks_.begin(), tracks_.end(), [&](const auto& entry) { return entry.first == key; });
  if (found == tracks_.end()) return nullptr;
  tracks_.splice(tracks_.begin(), tracks_, found);
  return found->second;
}

void FrameCameras::Add(const Digest& key, Track track) {
  const std::lock_guard lock(mutex_);
  tracks_.remove_if([&](const auto& entry) { return entry.first == key; });
  tracks_.emplace_front(key, std::move(track));
  if (tracks_.size() > kMost) tracks_.pop_back();
}

}  // namespace shutterline::server
