#include "worker/engine/accel/time_bounds.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/math/bezier.h"

namespace shutterline::engine {
namespace {

constexpr int kPlanes = 6;
constexpr int kCurveParts = 4;
/// Slack of the result, fraction of the shutter, and of a distance, relative to the sum of its terms'
/// magnitudes: a few roundings. Instants in between are decided exactly later.
constexpr double kClippedTimeSlack = 1e-9;
constexpr double kSumSlack = 16 * std::numeric_limits<double>::epsilon();

double Difference(double a, double b) {
  return a - b + kSumSlack * (std::abs(a) + std::abs(b));
}

/// Distances from the planes, up to positive factors and enlarged by their rounding; negative is outside.
std::array<double, kPlanes> Distances(const RasterBox& box, const RasterPoint& p) {
  return {Difference(p.x, box.x0 * p.w), Difference(box.x1 * p.w, p.x), Difference(p.y, box.y0 * p.w),
          Difference(box.y1 * p.w, p.y), Difference(p.w, p.z),          Difference(p.z, box.far_depth * p.w)};
}

/// Bounds within one part of the shutter, in [0, 1] of that part.
TimeInterval TimesInsidePart(const std::array<const RasterPoint*, 3>& points, int degree,
                             const RasterBox& box) {
  std::array<double, kPlanes> d[3][kMaxBezierDegree + 1];
  for (size_t k = 0; k < 3; ++k) {
    for (int i = 0; i <= degree; ++i) d[k][i] = Distances(box, points[k][i]);
  }
  TimeInterval inside{0, 1};
  for (size_t plane = 0; plane < kPlanes; ++plane) {
    TimeInterval here;
    for (const auto& of_vertex : d) {
      if (of_vertex[0][plane] >= 0) here.in = 0;
      if (of_vertex[degree][plane] >= 0) here.out = 1;
      // The hull's part above zero begins and ends on segments between coefficients of unequal sign.
      for (int i = 0; i < degree; ++i) {
        for (int j = i + 1; j <= degree; ++j) {
          const double a = of_vertex[i][plane], b = of_vertex[j][plane];
          if ((a < 0) == (b < 0)) continue;
          const double u = degree == 1 ? a / (a - b) : (i + (j - i) * (a / (a - b))) / degree;
          here.in = std::min(here.in, u);
          here.out = std::max(here.out, u);
        }
      }
    }
    inside.in = std::max(inside.in, here.in);
    inside.out = std::min(inside.out, here.out);
  }
  // Slack before emptiness is judged: planes may be met one after the other at the same instant.
  inside.in -= kClippedTimeSlack;
  inside.out += kClippedTimeSlack;
  return inside;
}

}  // namespace

TimeInterval TimesInside(const std::array<const RasterPoint*, 3>& points, int degree, int pieces,
                         const RasterBox& box) {
  if (degree == 0) {
    return TimesInsidePart(points, 0, box).IsEmpty() ? TimeInterval() : TimeInterval{0, 1};
  }
  const int parts = degree == 1 ? 1 : kCurveParts;
  const int count = pieces * parts;
  const auto part_inside = [&](int number) {
    const int first = number / parts * degree;
    std::array<const RasterPoint*, 3> part;
    RasterPoint cut[3][kMaxBezierDegree + 1];
    for (size_t k = 0; k < 3; ++k) {
      part[k] = points[k] + first;
      if (parts == 1) continue;
      BezierPart(part[k], degree, double(number % parts) / parts, double(number % parts + 1) / parts, cut[k]);
      part[k] = cut[k];
    }
    return TimesInsidePart(part, degree, box);
  };
  TimeInterval result;
  int first = 0;
  for (; first < count; ++first) {
    const TimeInterval inside = part_inside(first);
    if (inside.IsEmpty()) continue;
    result = {(first + inside.in) / count, (first + inside.out) / count};
    break;
  }
  for (int last = count - 1; last > first; --last) {
    const TimeInterval inside = part_inside(last);
    if (inside.IsEmpty()) continue;
    result.out = (last + inside.out) / count;
    break;
  }
  if (result.IsEmpty()) return {};
  return {std::max(0.0, result.in), std::min(1.0, result.out)};
}

}  // namespace shutterline::engine
