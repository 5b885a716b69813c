#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "common/math/spaces.h"
#include "worker/engine/visibility/pair_weights.h"
#include "worker/engine/visibility/point_colors.h"

namespace shutterline::engine {

/// The radiance over a triangle as a polynomial of the barycentric coordinates, given at its corners 0, 1, 2
/// and in the middles of its edges 01, 12, 20. Where it is linear the middles are not looked at.
struct ColorNodes {
  std::array<V3f, 3> corners{V3f(0), V3f(0), V3f(0)};
  std::array<V3f, 3> middles{V3f(0), V3f(0), V3f(0)};
  bool quadratic = false;
};

/// Sums of (radiance, coverage) per pixel of what need not be kept apart by triangle, because its radiance is
/// known beforehand: constant over a triangle, or smooth. Coverage sums are integers in units of
/// PairWeights::total() and stay exact; radiance sums are weighted by the same integers.
class ColorFilm {
 public:
  /// What a triangle of the frame looks like; nothing where that is not so simple.
  using Shader = std::function<std::optional<ColorNodes>(uint32_t triangle)>;

  /// One colour that stands for a triangle of the frame, good enough to measure how far two ways of sampling
  /// it are apart; nothing where it takes the colours of its points to tell.
  using Guesser = std::function<std::optional<V3f>(uint32_t triangle)>;

  /// Without a guesser nothing can be measured before it is rendered. `points`, which may be null and must
  /// outlive the film, is asked about triangles of which `shader`, or the guesser, says nothing.
  explicit ColorFilm(Shader shader, Guesser guesser = {}, PointColors* points = nullptr)
      : shader_(std::move(shader)), guesser_(std::move(guesser)), points_(points) {}

  /// From now on resolvers also tell which triangles they have added, see pairs().
  void KeepPairs() { keeps_pairs_ = true; }
  bool keeps_pairs() const { return keeps_pairs_; }

  /// `taps`: as PairWeights::Reset.
  void Reset(int64_t pixels, int taps = 0) {
    sums_.assign(size_t(pixels), {0, 0, 0, 0});
    if (keeps_pairs_) pairs_.Reset(pixels, 0, taps);
  }

  std::optional<ColorNodes> Shade(uint32_t triangle) const { return shader_(triangle); }
  bool CanGuess() const { return guesser_ != nullptr; }
  std::optional<V3f> Guess(uint32_t triangle) const { return guesser_(triangle); }
  bool HasPoints(uint32_t triangle) const { return points_ != nullptr && points_->Has(triangle); }
  /// Where it has points.
  PointColors& points() { return *points_; }

  /// Red, green, blue, coverage; `pixel` counts in rows within the tile.
  std::array<double, 4>& At(int64_t pixel) { return sums_[size_t(pixel)]; }
  const std::array<double, 4>& At(int64_t pixel) const { return sums_[size_t(pixel)]; }
  const std::vector<std::array<double, 4>>& sums() const { return sums_; }

  /// What has been added, by triangle, where that is kept; its total() means nothing.
  PairWeights& pairs() { return pairs_; }
  const PairWeights& pairs() const { return pairs_; }

 private:
  Shader shader_;
  Guesser guesser_;
  PointColors* points_;
  std::vector<std::array<double, 4>> sums_;
  bool keeps_pairs_ = false;
  PairWeights pairs_;
};

}  // namespace shutterline::engine
