#include "worker/engine/occlusion/hemisphere_lines.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <numeric>

namespace shutterline::engine {
namespace {

/// A plane that leans fully is the horizon's own and cuts the hemisphere nowhere.
constexpr double kMostLean = 1 - 0x1p-20;

double Fraction(double v) {
  return v - std::floor(v);
}

/// A step through the strata of time that no small number of lines brings back: near the golden section of
/// their number, and without a common divisor with it.
int64_t TimeStep(int lines) {
  int64_t step = std::max<int64_t>(1, std::llround(lines * (std::numbers::phi - 1)));
  while (std::gcd(step, int64_t{lines}) != 1) ++step;
  return step;
}

}  // namespace

Heading HeadingOf(double turns) {
  // Turn back to the nearest quarter, expand about it.
  const double quarter = std::floor(4 * turns + 0.5);
  const double x = (turns - quarter / 4) * (2 * std::numbers::pi);
  const double xx = x * x;
  double cosine = 1, sine = 1;
  for (int n = 18; n > 0; n -= 2) {
    cosine = 1 - xx / (n * (n - 1)) * cosine;
    sine = 1 - xx / (n * (n + 1)) * sine;
  }
  sine *= x;
  switch (int64_t(quarter) & 3) {
    case 0:
      return {cosine, sine};
    case 1:
      return {-sine, cosine};
    case 2:
      return {-cosine, -sine};
    default:
      return {sine, -cosine};
  }
}

HemisphereLine LineAt(const OcclusionSettings& settings, int i, const LineShifts& shifts) {
  const int n = settings.lines;
  HemisphereLine line;
  if (settings.pattern == OcclusionPattern::kPole) {
    line.heading = HeadingOf((i + shifts.position) / (2.0 * n));
  } else {
    // What the first and the last line see differs. Neighbours are shifted against each other, so that it
    // does not matter where in their strata they are.
    const double place = (i + (i % 2 == 0 ? shifts.position : 1 - shifts.position)) / n;
    line.heading = HeadingOf(shifts.heading / 2);
    line.lean = std::clamp(2 * place - 1, -kMostLean, kMostLean);
  }
  if (settings.motion) line.instant = Fraction((double(i * TimeStep(n) % n) + 0.5) / n + shifts.instant);
  return line;
}

LineShifts ShiftsOfPixel(double raster_x, double raster_y) {
  constexpr double kFarthest = 0x1p30;
  if (!(std::abs(raster_x) < kFarthest && std::abs(raster_y) < kFarthest)) return {};
  const double x = std::floor(raster_x), y = std::floor(raster_y);
  // Powers of the inverses of the roots of r³ = r + 1 and r⁴ = r + 1, whose multiples spread evenly.
  return {.position = Fraction(0.5 + 0.7548776662466927 * x + 0.5698402909980532 * y),
          .heading = Fraction(0.5 + 0.5698402909980532 * x + 0.2451223337533073 * y),
          .instant = Fraction(0.5 + 0.8191725133961645 * x + 0.6710436067037893 * y)};
}

}  // namespace shutterline::engine
