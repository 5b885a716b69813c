#pragma once

#include <cmath>
#include <cstdint>

#include "common/math/spaces.h"

namespace shutterline::engine {

/// Number `i` of `count` well spread half vectors about +z, as dense as GGX facets seen head-on:
/// D(h) · N·H per steradian. A Hammersley set, so the same in every process.
inline V3d HalfVector(int i, int count, double alpha) {
  uint32_t bits = uint32_t(i);
  bits = (bits << 16) | (bits >> 16);
  bits = ((bits & 0x00ff00ffu) << 8) | ((bits & 0xff00ff00u) >> 8);
  bits = ((bits & 0x0f0f0f0fu) << 4) | ((bits & 0xf0f0f0f0u) >> 4);
  bits = ((bits & 0x33333333u) << 2) | ((bits & 0xccccccccu) >> 2);
  bits = ((bits & 0x55555555u) << 1) | ((bits & 0xaaaaaaaau) >> 1);
  const double u = (i + 0.5) / count;
  const double v = bits * 0x1p-32;
  const double cos_squared = (1 - u) / (1 + (alpha * alpha - 1) * u);
  const double sine = std::sqrt(std::max(0.0, 1 - cos_squared));
  const double angle = 2 * M_PI * v;
  return {sine * std::cos(angle), sine * std::sin(angle), std::sqrt(cos_squared)};
}

}  // namespace shutterline::engine
