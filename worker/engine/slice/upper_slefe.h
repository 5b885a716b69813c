#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

#include "common/math/bezier.h"

namespace shutterline::engine {

/// Equal segments of a slefe.
inline constexpr size_t kSlefeSegments = 4;

/// Upper bounds of N Bezier polynomials of one degree (1 to kMaxBezierDegree) on [0, 1] at once: the values
/// at the ends of kSlefeSegments equal segments of piecewise linear functions that lie nowhere below them (a
/// subdividable linear efficient function enclosure, as [gribel2013, section 4.2] uses them); `c[i][n]` is
/// coefficient i of polynomial n.
///
/// A polynomial is the straight line between its ends plus its second differences times fixed functions,
/// which are convex. Such a function lies below its chords, which bound it where the difference is positive,
/// and above them by no more than an eighth of its largest second derivative times the segment's length
/// squared, which bounds it where the difference is negative. Rounding is added.
template <size_t N>
void UpperSlefe(const std::array<std::array<double, N>, kMaxBezierDegree + 1>& c, int degree,
                std::array<std::array<double, N>, kSlefeSegments + 1>& upper) {
  // The convex functions at the segments' ends, and bounds below: of degree 2, -u (1 - u), and of degree 3,
  // -u (1 - u) (2 - u) and its mirror image.
  using Ends = std::array<double, kSlefeSegments + 1>;
  static constexpr Ends kChords2{0, -0.1875, -0.25, -0.1875, 0};
  static constexpr Ends kBelow2{-0.015625, -0.203125, -0.265625, -0.203125, -0.015625};
  static constexpr Ends kChords3{0, -0.328125, -0.375, -0.234375, 0};
  static constexpr Ends kBelow3{-0.046875, -0.375, -0.41015625, -0.2578125, -0.01171875};
  constexpr double kRounding = 16 * std::numeric_limits<double>::epsilon();

  for (size_t n = 0; n < N; ++n) {
    const double begin = c[0][n];
    const double end = c[size_t(degree)][n];
    double magnitude = 0;
    for (int i = 0; i <= degree; ++i) magnitude += std::abs(c[size_t(i)][n]);
    for (size_t j = 0; j <= kSlefeSegments; ++j) {
      const double u = double(j) / double(kSlefeSegments);
      upper[j][n] = (1 - u) * begin + u * end + kRounding * magnitude;
    }
    if (degree == 2) {
      const double bend = c[0][n] - 2 * c[1][n] + c[2][n];
      const double up = std::max(bend, 0.0), down = std::min(bend, 0.0);
      for (size_t j = 0; j <= kSlefeSegments; ++j) upper[j][n] += up * kChords2[j] + down * kBelow2[j];
    } else if (degree == 3) {
      const double first = c[0][n] - 2 * c[1][n] + c[2][n];
      const double second = c[1][n] - 2 * c[2][n] + c[3][n];
      const double first_up = std::max(first, 0.0), first_down = std::min(first, 0.0);
      const double second_up = std::max(second, 0.0), second_down = std::min(second, 0.0);
      for (size_t j = 0; j <= kSlefeSegments; ++j) {
        const size_t mirrored = kSlefeSegments - j;
        upper[j][n] += (first_up * kChords3[j] + first_down * kBelow3[j]) +
                       (second_up * kChords3[mirrored] + second_down * kBelow3[mirrored]);
      }
    }
  }
}

}  // namespace shutterline::engine
