#pragma once

#include <array>

namespace shutterline::engine {

/// A corner in homogeneous line coordinates: row · w, position · w, depth · w, w.
using LineCorner = std::array<double, 4>;

/// A triangle cut by two planes has at most five corners.
struct ClippedPolygon {
  int count = 0;
  std::array<LineCorner, 5> corners{};
};

/// Cuts a triangle at the near plane (w >= z) and the far plane (z >= far_depth · w). A new corner is
/// computed from the end of its edge that is inside and the one that is outside, in that order, so neighbours
/// get it bit-equal. Fewer than three corners: nothing is left.
ClippedPolygon ClipTriangle(const std::array<LineCorner, 3>& corners, double far_depth);

}  // namespace shutterline::engine
