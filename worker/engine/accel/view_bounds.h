#pragma once

#include <array>

namespace shutterline::engine {

/// Bounds in view space divided by a scale, rounded outwards.
struct ViewBounds {
  std::array<float, 3> lower, upper;
};

}  // namespace shutterline::engine
