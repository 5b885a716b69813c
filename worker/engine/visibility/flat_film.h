#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "common/math/spaces.h"

namespace shutterline::engine {

/// Sums of (radiance, coverage) per pixel of what has the same colour all over a triangle: it need not be
/// kept apart by triangle. Coverage sums are integers in units of PairWeights::total() and stay exact;
/// radiance sums are weighted by the same integers.
class FlatFilm {
 public:
  /// Radiance of a triangle of the frame whose primitive does not need positions.
  using Shader = std::function<V3f(uint32_t triangle)>;

  explicit FlatFilm(Shader shader) : shader_(std::move(shader)) {}

  void Reset(int64_t pixels) { sums_.assign(size_t(pixels), {0, 0, 0, 0}); }

  V3f Shade(uint32_t triangle) const { return shader_(triangle); }

  /// Red, green, blue, coverage; `pixel` counts in rows within the tile.
  std::array<double, 4>& At(int64_t pixel) { return sums_[size_t(pixel)]; }
  const std::array<double, 4>& At(int64_t pixel) const { return sums_[size_t(pixel)]; }

 private:
  Shader shader_;
  std::vector<std::array<double, 4>> sums_;
};

}  // namespace shutterline::engine
