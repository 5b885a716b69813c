#pragma once

#include <bit>
#include <cstdint>

#include "common/job/occlusion_settings.h"

namespace shutterline::engine {

/// A position along a line sample, l in [-1, 1] [gribel2011, figure 6], is an integer of 2^-30: two triangles
/// that share an edge then end and begin at one and the same, and a line that is full is known to be.
inline constexpr int32_t kLineEnd = int32_t{1} << 30;
inline constexpr double kLineUnit = 1.0 / kLineEnd;

/// Added to a number of magnitude below 2^50, leaves it rounded to the nearest integer in the low digits.
inline constexpr double kRounder = 0x1.8p52;

/// l as an integer, by the same roundings as in vectors: `rounded` is kRounder + l kLineEnd.
inline int32_t PositionFrom(double rounded) {
  return int32_t(uint32_t(std::bit_cast<uint64_t>(rounded)));
}

/// The whole of a line. Shares are integers so that sums do not depend on their order.
inline constexpr int64_t kWholeLine = int64_t{1} << 40;

/// What share of the hemisphere, as the lines of the pattern measure it, has positions below `l`: the
/// remapping that makes the pattern uniform on the disc. 0 at -kLineEnd, kWholeLine at kLineEnd, and
/// monotone. Same bits on every processor.
///
/// Lines through the pole: (1 + l |l|) / 2, the area of a double wedge. Tilted lines: the part of the disc to
/// the left of l, ½ + (asin l + l √(1 - l²)) / π.
int64_t ShareBelow(OcclusionPattern pattern, int32_t l);

/// Its derivative by the angle along the line, in the direction (l, height), a unit vector: 1 over the half
/// circle.
double DensityAt(OcclusionPattern pattern, double l, double height);

}  // namespace shutterline::engine
