#pragma once

#include <algorithm>
#include <cmath>

#include "common/math/spaces.h"

namespace shutterline {

/// `v` with length 1, whatever its magnitude (squares neither overflow nor vanish); the zero vector where
/// `v` is zero or not finite.
inline V3d UnitOrZero(V3d v) {
  // Of most vectors the square is far from the ends of what a double holds.
  const double square = v.dot(v);
  if (square > 1e-200 && square < 1e200) return v / std::sqrt(square);
  const double largest = std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
  if (!(largest > 0) || !std::isfinite(largest)) return V3d(0);
  v /= largest;
  return v / std::sqrt(v.dot(v));
}

}  // namespace shutterline
