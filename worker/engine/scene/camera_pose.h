#pragma once

#include <array>
#include <optional>

#include "common/math/spaces.h"

namespace shutterline::engine {

/// Where a camera stands: a rigid motion, whatever scale its node has (glTF ignores it).
struct CameraPose {
  V3d position{0, 0, 0};                           ///< World, metres.
  V3d right{1, 0, 0}, up{0, 1, 0}, back{0, 0, 1};  ///< Orthonormal, right-handed; it looks along -back.

  /// view_from_object. The camera's position is subtracted before anything is rotated, so a scene far from
  /// the world's origin loses no more than its own numbers have lost already.
  M44d ViewFrom(const M44d& world_from_object) const;

  /// The world's x, y and z axes in view space.
  std::array<V3d, 3> WorldAxes() const {
    return {V3d(right.x, up.x, back.x), V3d(right.y, up.y, back.y), V3d(right.z, up.z, back.z)};
  }
};

/// The camera of a node: its axes made orthonormal, keeping the view direction and then the up direction.
/// Nothing where they are not finite or do not span space.
std::optional<CameraPose> CameraPoseFrom(const M44d& world_from_camera);

/// A camera at `position` that looks at `target` with the world's y axis up in the picture. `position` must
/// neither equal `target` nor lie straight above or below it.
CameraPose LookAt(const V3d& position, const V3d& target);

}  // namespace shutterline::engine
