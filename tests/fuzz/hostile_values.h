#pragma once

#include <cstddef>
#include <cstdint>
#include <random>

namespace shutterline::engine {

/// Numbers that arithmetic dislikes: of every exponent, denormal, zero, equal to an earlier one or next to
/// it, on lines and on the borders of pixels and subpixels. The same seed gives the same numbers.
class HostileValues {
 public:
  explicit HostileValues(uint64_t seed) : random_(seed) {}

  std::mt19937_64& random() { return random_; }
  bool Chance(double probability) { return Unit() < probability; }
  double Unit() { return double(random_() >> 11) * 0x1p-53; }
  /// In [0, n).
  size_t Index(size_t n) { return size_t(random_() % n); }
  int Int(int low, int high) { return low + int(Index(size_t(high - low + 1))); }

  /// A position around a tile of `side` pixels, or far from it; never larger than kMaxCoordinate.
  double Position(int side);
  /// Either sign, any exponent from denormals up to kMaxCoordinate.
  double AnyMagnitude();
  /// The homogeneous w of a point: around `near`, zero, negative, or of any size.
  double W(double near);
  /// As W, but at or beyond the near plane, and at least 2^-100.
  double WInFront(double near);

 private:
  double FreshPosition(int side);

  std::mt19937_64 random_;
  double last_[4] = {0, 0, 0.5, 1};
  size_t count_ = 0;
};

}  // namespace shutterline::engine
