#include "worker/engine/scene/shutter_poses.h"

#include <absl/strings/str_cat.h>

#include <utility>

#include "common/base/work_limit.h"

namespace shutterline::engine {

ShutterPoses::ShutterPoses(const Scene& scene, PoseSampler sampler, int camera_node, double open_seconds,
                           double close_seconds)
    : scene_(scene),
      sampler_(std::move(sampler)),
      camera_node_(camera_node),
      open_seconds_(open_seconds),
      close_seconds_(close_seconds) {}

bool ShutterPoses::CameraMoves() const {
  return !fixed_camera_ && sampler_.Moves(camera_node_);
}

absl::StatusOr<Moment> ShutterPoses::At(double t) const {
  CheckWork();
  const double seconds = t == 0   ? open_seconds_
                         : t == 1 ? close_seconds_
                                  : (1 - t) * open_seconds_ + t * close_seconds_;
  Moment moment{sampler_.At(seconds), CameraPose()};
  if (fixed_camera_) {
    moment.camera = *fixed_camera_;
    return moment;
  }
  const std::optional<CameraPose> camera = CameraPoseFrom(moment.pose.world_from_node[size_t(camera_node_)]);
  if (!camera) {
    return absl::InvalidArgumentError(absl::StrCat(
        "scene ", scene_.name, ": camera node ", camera_node_, " \"", scene_.nodes[size_t(camera_node_)].name,
        "\" has no orientation at ", seconds, " s: its axes are zero, parallel or not finite"));
  }
  moment.camera = *camera;
  return moment;
}

std::vector<double> ShutterPoses::KeyTimes(size_t max_count) const {
  std::vector<double> times;
  for (const double key : sampler_.KeyTimes(open_seconds_, close_seconds_, max_count)) {
    times.push_back((key - open_seconds_) / (close_seconds_ - open_seconds_));
  }
  return times;
}

}  // namespace shutterline::engine
