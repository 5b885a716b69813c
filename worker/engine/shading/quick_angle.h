#pragma once

#include <algorithm>
#include <cmath>

namespace shutterline::engine {

/// std::atan2(y, x) within 1e-9, without a branch that processors could guess wrong often, and the same on
/// all machines, which libraries' are not. Zero where both are.
inline double QuickAngle(double y, double x) {
  const double across = std::abs(x), up = std::abs(y);
  const double low = std::min(across, up), high = std::max(across, up);
  if (!(high > 0)) return 0;
  // Turn by an eighth of a circle what is beyond a sixteenth.
  constexpr double kTanSixteenth = 0.41421356237309503;
  const bool turned = low > kTanSixteenth * high;
  const double tangent = turned ? (low - high) / (low + high) : low / high;
  // Interpolates atan(t) / t at the six Chebyshev nodes of t² in [0, kTanSixteenth²].
  const double s = tangent * tangent;
  const double s2 = s * s;
  const double series = (0.9999999993712282 - 0.33333306893050235 * s) +
                        s2 * ((0.1999818304113337 - 0.14239532670301167 * s) +
                              s2 * (0.10569828810438991 - 0.06026305236996569 * s));
  double angle = tangent * series + (turned ? M_PI / 4 : 0.0);
  if (up > across) angle = M_PI / 2 - angle;
  if (x < 0) angle = M_PI - angle;
  return y < 0 ? -angle : angle;
}

}  // namespace shutterline::engine
