#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "common/math/spaces.h"

/// Well spread half vectors, the same in every process.
namespace shutterline::engine {

/// Point `i` of a Hammersley set of `count` in the unit square.
inline V2d HammersleyPoint(int i, int count) {
  uint32_t bits = uint32_t(i);
  bits = (bits << 16) | (bits >> 16);
  bits = ((bits & 0x00ff00ffu) << 8) | ((bits & 0xff00ff00u) >> 8);
  bits = ((bits & 0x0f0f0f0fu) << 4) | ((bits & 0xf0f0f0f0u) >> 4);
  bits = ((bits & 0x33333333u) << 2) | ((bits & 0xccccccccu) >> 2);
  bits = ((bits & 0x55555555u) << 1) | ((bits & 0xaaaaaaaau) >> 1);
  return {(i + 0.5) / count, bits * 0x1p-32};
}

/// Half vectors about +z as dense as the GGX facets that are seen from `view`, a unit vector above the
/// surface [heitz2018]: facets are those of an ellipsoid, which becomes a hemisphere where α = 1.
inline V3d VisibleHalfVector(const V2d& u, double alpha, const V3d& view) {
  const V3d stretched = V3d(alpha * view.x, alpha * view.y, view.z).normalized();
  const double length = std::hypot(stretched.x, stretched.y);
  const V3d across = length > 0 ? V3d(-stretched.y / length, stretched.x / length, 0) : V3d(1, 0, 0);
  const V3d up = stretched.cross(across);
  // A point of the hemisphere's outline as it is seen: a disk whose lower half is foreshortened.
  const double radius = std::sqrt(u.x);
  const double angle = 2 * M_PI * u.y;
  const double x = radius * std::cos(angle);
  const double seen = 0.5 * (1 + stretched.z);
  const double y = (1 - seen) * std::sqrt(std::max(0.0, 1 - x * x)) + seen * radius * std::sin(angle);
  const V3d normal = x * across + y * up + std::sqrt(std::max(0.0, 1 - x * x - y * y)) * stretched;
  return V3d(alpha * normal.x, alpha * normal.y, std::max(1e-9, normal.z)).normalized();
}

}  // namespace shutterline::engine
