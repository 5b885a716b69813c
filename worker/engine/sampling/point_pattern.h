#pragma once

#include <array>
#include <cstdint>

namespace shutterline::engine {

/// A point of a pixel and the shutter, each coordinate in [0, 1): x and y from the pixel's top left corner,
/// t from shutter open.
struct PixelPoint {
  double x = 0, y = 0, t = 0;
};

/// The points of one pixel: a Sobol' sequence in (x, y, t) under Owen's nested uniform scrambling, which is
/// a hash of the point's bits (burley2020). Point i depends on nothing but i and the keys; every point is
/// uniform in the unit cube, the first 2^k points have one in each of 2^k equal intervals of every axis, and
/// x and y make a (0, 2)-sequence: one in each rectangle of area 2^-k of the 2^k points.
class PixelPoints {
 public:
  explicit PixelPoints(const std::array<uint64_t, 3>& keys) : keys_(keys) {}

  /// The digits of a point before scrambling, which all pixels share; for loops over pixels.
  using Digits = std::array<uint32_t, 3>;
  static Digits DigitsOf(uint32_t index);

  PixelPoint At(uint32_t index) const { return At(DigitsOf(index)); }
  PixelPoint At(const Digits& digits) const;

 private:
  std::array<uint64_t, 3> keys_;
};

/// Low-discrepancy points in (x, y, t) for every pixel of a frame. Pixels, frames and seeds have independent
/// scramblings. A pixel's points depend only on its absolute coordinates, never on the tile it is in.
class PointPattern {
 public:
  PointPattern(uint64_t seed, int64_t frame);

  PixelPoints Pixel(int x, int y) const;

 private:
  uint64_t frame_key_;
};

}  // namespace shutterline::engine
