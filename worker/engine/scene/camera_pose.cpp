#include "worker/engine/scene/camera_pose.h"

#include <cmath>

#include "common/math/unit_vector.h"

namespace shutterline::engine {

M44d CameraPose::ViewFrom(const M44d& m) const {
  M44d view;
  for (int row = 0; row < 4; ++row) {
    V3d v(m[row][0], m[row][1], m[row][2]);
    if (row == 3) v -= position;
    view[row][0] = v.dot(right);
    view[row][1] = v.dot(up);
    view[row][2] = v.dot(back);
  }
  return view;
}

std::optional<CameraPose> CameraPoseFrom(const M44d& m) {
  CameraPose pose;
  pose.position = V3d(m[3][0], m[3][1], m[3][2]);
  pose.back = UnitOrZero(V3d(m[2][0], m[2][1], m[2][2]));
  const V3d up = UnitOrZero(V3d(m[1][0], m[1][1], m[1][2]));
  const V3d across = up - up.dot(pose.back) * pose.back;
  // Below this angle between the axes, rounding would decide where up is.
  if (!(across.dot(across) > 1e-24)) return std::nullopt;
  pose.up = UnitOrZero(across);
  pose.right = pose.up.cross(pose.back);
  const double sum = pose.position.x + pose.position.y + pose.position.z;
  if (!(pose.back.dot(pose.back) > 0.5) || !std::isfinite(sum)) return std::nullopt;
  return pose;
}

CameraPose LookAt(const V3d& position, const V3d& target) {
  CameraPose pose;
  pose.position = position;
  pose.back = UnitOrZero(position - target);
  pose.right = UnitOrZero(V3d(0, 1, 0).cross(pose.back));
  pose.up = pose.back.cross(pose.right);
  return pose;
}

}  // namespace shutterline::engine
