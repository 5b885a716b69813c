#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

namespace shutterline::engine {

/// The logarithm of base 2 of a normal positive number, within 2e-9, and exact for powers of two. The same
/// on all machines, which libraries' are not. Infinity counts as 2^1024.
inline double Log2(double x) {
  // x = 2^exponent m, with m in [√½, √2).
  constexpr uint64_t kMantissa = (uint64_t{1} << 52) - 1, kOne = uint64_t{1023} << 52;
  const auto bits = std::bit_cast<uint64_t>(x);
  double exponent = double(int64_t(bits >> 52) - 1023);
  double m = std::bit_cast<double>((bits & kMantissa) | kOne);
  if (m > 1.4142135623730951) {
    m *= 0.5;
    exponent += 1;
  }
  // ln m = 2 artanh s, |s| < 0.172; the first term left out, 2 s^11 / (11 ln 2), is below 1.1e-9.
  const double s = (m - 1) / (m + 1), s2 = s * s;
  const double series = 1 + s2 * (1.0 / 3 + s2 * (1.0 / 5 + s2 * (1.0 / 7 + s2 * (1.0 / 9))));
  return exponent + s * series * (2 / M_LN2);
}

}  // namespace shutterline::engine
