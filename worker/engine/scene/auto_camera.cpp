#include "worker/engine/scene/auto_camera.h"

#include <algorithm>
#include <cmath>

namespace shutterline::engine {
namespace {

constexpr double kVerticalFieldOfView = 0.6;      ///< Radians.
constexpr double kFill = 0.9;                     ///< Of the frame's half width and half height.
constexpr double kNearFraction = 0.01;            ///< Of the distance to the centre.
const V3d kTowardsCamera = V3d(0.55, 0.42, 0.9);  ///< From the centre; any length.

}  // namespace

AutoCamera MakeAutoCamera(const Box3d& bounds, int width, int height) {
  const Box3d box = bounds.isEmpty() ? Box3d(V3d(-0.5), V3d(0.5)) : bounds;
  const V3d center = 0.5 * box.min + 0.5 * box.max;
  const V3d half = 0.5 * box.max - 0.5 * box.min;
  const double tan_y = kFill * std::tan(0.5 * kVerticalFieldOfView);
  const double tan_x = tan_y * width / height;

  // Step back until every corner of the box is inside the frame.
  CameraPose pose = LookAt(kTowardsCamera, V3d(0));
  double distance = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const V3d p(corner & 1 ? half.x : -half.x, corner & 2 ? half.y : -half.y, corner & 4 ? half.z : -half.z);
    const double needed = std::max(std::abs(p.dot(pose.right)) / tan_x, std::abs(p.dot(pose.up)) / tan_y);
    distance = std::max(distance, needed + p.dot(pose.back));
  }
  if (!(distance > 0))
    distance = std::max({1e-30, std::abs(center.x), std::abs(center.y), std::abs(center.z)});

  AutoCamera result;
  result.camera.name = "automatic";
  result.camera.yfov = kVerticalFieldOfView;
  result.camera.znear = kNearFraction * distance;
  pose.position = center + distance * pose.back;
  result.pose = pose;
  return result;
}

}  // namespace shutterline::engine
