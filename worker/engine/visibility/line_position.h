#pragma once

#include <algorithm>
#include <array>

namespace shutterline::engine {

/// Perspective-correct position on a triangle along a line: barycentric coordinates b1 and b2 and their sum
/// with b0, all over w, each at + per_pixel · l. Divide the first two by the third.
struct LinePosition {
  std::array<double, 3> at{1.0 / 3, 1.0 / 3, 1}, per_pixel{0, 0, 0};
};

/// x within [0, most]; 0 for what is not a number, as positions on triangles that are all but seen edge-on.
inline double ClampedFromZero(double x, double most) {
  return x > 0 ? std::min(x, most) : 0;
}

}  // namespace shutterline::engine
