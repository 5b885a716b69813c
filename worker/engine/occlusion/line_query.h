#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "common/math/spaces.h"
#include "worker/engine/occlusion/occluder_tree.h"

namespace shutterline::engine {

/// Bernstein weights of the control points that an instant lies between, for one class of motion.
struct MotionWeights {
  int first = 0, count = 1;  ///< Of the vertex's control points.
  std::array<double, 4> weights{1, 0, 0, 0};
};

/// A line sample at its instant, in the units and axes of an OccluderTree.
struct LineQuery {
  V3d point{0, 0, 0};
  V3d along{1, 0, 0}, up{0, 0, 1}, plane{0, 1, 0};  ///< Unit; the last is the normal of the line's plane.
  V3d face{0, 0, 1};
  double face_along = 0, face_up = 1;  ///< `face` in the line's plane.
  double radius = 0;                   ///< Infinity: none.
  OccluderPlace own;                   ///< What the point lies on does not occlude it.

  /// What rounding makes of heights over the face. Something at a distance of r that lies in the triangle's
  /// plane may seem to be kHeightRoundings (size (1 + r inverse_height) + r) over it: positions of corners
  /// are known to some roundings of their coordinates, so a direction of the plane to those over the
  /// triangle's least height. What is no higher does not occlude, so that on a flat or convex surface nothing
  /// does.
  double size = 0;            ///< Largest sum of the magnitudes of a corner's coordinates.
  double inverse_height = 0;  ///< 1 over the least height of the triangle.

  int span = 0;
  float in_span = 0;                       ///< Where the instant lies in its span, 0 to 1.
  std::span<const MotionWeights> motions;  ///< By class of motion.
};

/// Roundings of double precision that positions, and planes through them, may have been through: a few dozen.
inline constexpr double kHeightRoundings = 0x1p-53 * 128;

/// What a triangle's section with the line's plane is: places of its ends along and up, times a positive
/// weight, which saves a division where directions will do. Ends that triangles share are the same to the
/// bit.
struct LineSection {
  double along0, up0, weight0;
  double along1, up1, weight1;
};

}  // namespace shutterline::engine
