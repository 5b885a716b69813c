#pragma once

#include "common/math/spaces.h"

namespace shutterline::engine {

/// What shading finds of a point.
struct Shaded {
  V3f radiance{0, 0, 0};  ///< Linear, towards the camera.
  float openness =
      1;  ///< The part of the surroundings that it sees: ambient occlusion, 1 where none is computed.

  friend bool operator==(const Shaded&, const Shaded&) = default;
};

}  // namespace shutterline::engine
