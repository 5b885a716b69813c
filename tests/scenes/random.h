#pragma once

#include <cmath>
#include <cstdint>

#include "common/math/spaces.h"

namespace shutterline::scenes {

/// Random numbers that are the same everywhere, which the standard library's distributions are not:
/// SplitMix64 (Steele, Lea and Flood 2014).
class Random {
 public:
  explicit Random(uint64_t seed) : state_(seed) {}

  uint64_t Bits() {
    uint64_t z = state_ += 0x9e3779b97f4a7c15;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
    z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
    return z ^ (z >> 31);
  }
  /// In [low, high).
  double Uniform(double low = 0, double high = 1) {
    return low + (high - low) * (double(Bits() >> 11) * 0x1p-53);
  }
  /// In [0, count).
  int Index(int count) { return int(Bits() % uint64_t(count)); }
  /// Uniform on the unit sphere.
  V3f Direction() {
    const double z = Uniform(-1, 1), angle = Uniform(0, 2 * M_PI), r = std::sqrt(1 - z * z);
    return V3f(float(r * std::cos(angle)), float(r * std::sin(angle)), float(z));
  }

 private:
  uint64_t state_;
};

}  // namespace shutterline::scenes
