#include "worker/engine/accel/swept_bounds.h"

#include <cmath>

namespace shutterline::engine {
namespace {

/// Relative to the sum of the absolute values of terms: covers some roundings of 2^-53 each, with room.
constexpr double kProjectionSlack = 16 * std::numeric_limits<double>::epsilon();
constexpr double kBeyondPixels = 0x1p30;

/// The nearest float not above `value`.
float RoundDownPixels(double value) {
  const double cut = std::clamp(value, -kBeyondPixels, kBeyondPixels);
  const auto f = float(cut);
  return double(f) > cut ? std::nextafter(f, -std::numeric_limits<float>::infinity()) : f;
}

/// Bounds in double precision, as they grow.
class Growing {
 public:
  /// A projected point; `x_terms` and so on are the sums of the magnitudes that its coordinates were made of.
  void Add(const RasterPoint& p, double x_terms, double y_terms, double w_terms) {
    const double inverse = 1 / p.w;
    const double x = p.x * inverse;
    const double y = p.y * inverse;
    const double x_error = kProjectionSlack * inverse * (x_terms + std::abs(x) * w_terms);
    const double y_error = kProjectionSlack * inverse * (y_terms + std::abs(y) * w_terms);
    x0_ = std::min(x0_, x - x_error);
    y0_ = std::min(y0_, y - y_error);
    x1_ = std::max(x1_, x + x_error);
    y1_ = std::max(y1_, y + y_error);
  }
  SweptBounds Rounded() const {
    if (x0_ > x1_) return {};
    return {RoundDownPixels(x0_), RoundDownPixels(y0_), -RoundDownPixels(-x1_), -RoundDownPixels(-y1_)};
  }

 private:
  double x0_ = std::numeric_limits<double>::infinity(), y0_ = x0_, x1_ = -x0_, y1_ = -x0_;
};

/// By how much more than its rounding `a` is less than `b`; not positive if it is not.
double Below(double a, double b) {
  return b - a - kProjectionSlack * (std::abs(a) + std::abs(b));
}

}  // namespace

SweptBounds BoundsInRaster(std::span<const RasterPoint> hull, double far_depth) {
  Growing bounds;
  bool all_behind_far = true;
  bool any_behind_near = false;
  for (const RasterPoint& p : hull) {
    all_behind_far &= Below(p.z, far_depth * p.w) > 0;
    if (Below(p.w, p.z) > 0) {
      any_behind_near = true;
      continue;
    }
    if (!(p.w > 0))
      return {float(-kBeyondPixels), float(-kBeyondPixels), float(kBeyondPixels), float(kBeyondPixels)};
    bounds.Add(p, std::abs(p.x), std::abs(p.y), p.w);
  }
  if (all_behind_far) return {};
  if (!any_behind_near) return bounds.Rounded();

  for (const RasterPoint& behind : hull) {
    if (!(Below(behind.w, behind.z) > 0)) continue;
    for (const RasterPoint& front : hull) {
      const double distance = front.w - front.z;
      if (!(distance > 0) || Below(front.w, front.z) > 0) continue;
      const double other = behind.z - behind.w;
      const double a = other / (distance + other);
      const double b = distance / (distance + other);
      RasterPoint cut = a * front + b * behind;
      // On the plane w = z, and w may have cancelled where z has not.
      cut.w = std::max(cut.w, cut.z);
      if (!(cut.w > 0))
        return {float(-kBeyondPixels), float(-kBeyondPixels), float(kBeyondPixels), float(kBeyondPixels)};
      bounds.Add(cut, a * std::abs(front.x) + b * std::abs(behind.x),
                 a * std::abs(front.y) + b * std::abs(behind.y),
                 a * std::abs(front.z) + b * std::abs(behind.z));
    }
  }
  return bounds.Rounded();
}

}  // namespace shutterline::engine
