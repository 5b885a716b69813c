#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <vector>

#include "common/math/spaces.h"
#include "worker/engine/scene/frame_scene.h"

namespace shutterline::engine {

/// Empty by default.
struct OccluderBox {
  V3d lower{std::numeric_limits<double>::infinity()}, upper{-std::numeric_limits<double>::infinity()};

  void Extend(const V3d& p) {
    for (int axis = 0; axis < 3; ++axis) {
      lower[axis] = std::min(lower[axis], p[axis]);
      upper[axis] = std::max(upper[axis], p[axis]);
    }
  }
  void Extend(const OccluderBox& other) {
    Extend(other.lower);
    Extend(other.upper);
  }
};

/// A box that moves straight from the one place to the other.
struct MovingBox {
  OccluderBox open, close;

  void Extend(const MovingBox& other) {
    open.Extend(other.open);
    close.Extend(other.close);
  }
};

/// Where a frame's triangles are over equal spans of the shutter, in view space divided by `scale` and
/// relative to `centre`.
struct OccluderMotion {
  const FrameScene& frame;
  bool moves;  ///< Else all stays where it is at mid-shutter.
  double scale;
  V3d centre;
  int spans;  ///< A power of two.

  /// A box that moves straight between the places that the triangle has at the ends of the span, widened by
  /// what the control points deviate from that: it holds the triangle at every instant of the span.
  MovingBox Bound(uint32_t triangle, int span) const;

 private:
  void AppendHull(const FramePrimitive& primitive, uint32_t vertex, int span, std::vector<V3d>& hull) const;
};

}  // namespace shutterline::engine
