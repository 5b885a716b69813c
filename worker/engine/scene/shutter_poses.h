#pragma once

#include <absl/status/statusor.h>

#include <optional>
#include <vector>

#include "worker/engine/scene/camera_pose.h"
#include "worker/engine/scene/pose.h"

namespace shutterline::engine {

/// All nodes and the camera at one time.
struct Moment {
  Pose pose;
  CameraPose camera;
};

/// Poses a scene and its camera at any time of one shutter. Immutable but for SetFixedCamera; any number of
/// threads may ask.
class ShutterPoses {
 public:
  /// The camera hangs on `camera_node`, until one that never moves is set.
  ShutterPoses(const Scene& scene, PoseSampler sampler, int camera_node, double open_seconds,
               double close_seconds);

  void SetFixedCamera(const CameraPose& camera) { fixed_camera_ = camera; }

  const PoseSampler& sampler() const { return sampler_; }
  bool IsStill() const { return open_seconds_ == close_seconds_; }
  bool CameraMoves() const;

  /// `t` in [0, 1]; 0 and 1 are exactly open and close. INVALID_ARGUMENT where the camera's node has no
  /// orientation.
  absl::StatusOr<Moment> At(double t) const;

  /// Keys within the shutter, as shutter times, ascending; at most `max_count`, taken evenly from all.
  std::vector<double> KeyTimes(size_t max_count) const;

 private:
  const Scene& scene_;
  PoseSampler sampler_;
  int camera_node_;
  std::optional<CameraPose> fixed_camera_;
  double open_seconds_, close_seconds_;
};

}  // namespace shutterline::engine
