#pragma once

#include <absl/status/statusor.h>

#include <memory>
#include <optional>

#include "common/image/exr.h"
#include "common/job/render_settings.h"
#include "worker/engine/scene/auto_camera.h"
#include "worker/engine/scene/camera_select.h"
#include "worker/engine/scene/frame_scene.h"
#include "worker/engine/scene/pose.h"

namespace shutterline::engine {

/// Where the camera of a job is in all its frames, kept without the scene's meshes and pictures. Immutable.
class CameraTrack {
 public:
  /// INVALID_ARGUMENT where the settings name a camera or an animation that the scene does not have.
  static absl::StatusOr<CameraTrack> Make(const Scene& scene, const RenderSettings& settings);

  /// At the middle of a frame's shutter. INVALID_ARGUMENT where the camera has no orientation then.
  absl::StatusOr<CameraMatrices> At(int frame) const;

 private:
  CameraTrack(std::shared_ptr<const Scene> nodes, PoseSampler sampler, const RenderSettings& settings)
      : nodes_(std::move(nodes)),
        sampler_(std::move(sampler)),
        open_(settings.shutter_open),
        close_(settings.shutter_close),
        fps_(settings.fps) {}

  std::shared_ptr<const Scene> nodes_;  ///< What the sampler refers to.
  PoseSampler sampler_;
  double open_, close_;  ///< Frames.
  double fps_;
  int node_ = -1;                    ///< Of the camera.
  std::optional<CameraPose> fixed_;  ///< The automatic camera stands still.
  FrameView view_;
};

}  // namespace shutterline::engine
