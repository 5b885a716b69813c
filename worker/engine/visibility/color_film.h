#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "common/math/spaces.h"

namespace shutterline::engine {

/// Sums of (radiance, coverage) per pixel of what need not be kept apart by triangle, because its radiance is
/// known beforehand: constant over a triangle, or linear. Coverage sums are integers in units of
/// PairWeights::total() and stay exact; radiance sums are weighted by the same integers.
class ColorFilm {
 public:
  /// Radiance at a triangle's corners, between which it is linear; none where it is not, or not known.
  using CornerColors = std::optional<std::array<V3f, 3>>;
  using Shader = std::function<CornerColors(uint32_t triangle)>;

  explicit ColorFilm(Shader shader) : shader_(std::move(shader)) {}

  void Reset(int64_t pixels) { sums_.assign(size_t(pixels), {0, 0, 0, 0}); }

  CornerColors Shade(uint32_t triangle) const { return shader_(triangle); }

  /// Red, green, blue, coverage; `pixel` counts in rows within the tile.
  std::array<double, 4>& At(int64_t pixel) { return sums_[size_t(pixel)]; }
  const std::array<double, 4>& At(int64_t pixel) const { return sums_[size_t(pixel)]; }

 private:
  Shader shader_;
  std::vector<std::array<double, 4>> sums_;
};

}  // namespace shutterline::engine
