#include "worker/engine/accel/frustum_cull.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace shutterline::engine {
namespace {

/// Relative to the sum of the absolute values of a half-space's terms. Covers the roundings of such a sum
/// (about five) and of the planes' coefficients (about four), each 2^-53, with room.
constexpr double kRounding = 16 * std::numeric_limits<double>::epsilon();

/// Which of six half-spaces a point in homogeneous raster space is strictly outside of, one bit each.
struct OutsideOf {
  double x0, x1, y0, y1, far_depth;

  static unsigned Below(double a, double b, unsigned bit) {
    return a - b < -kRounding * (std::abs(a) + std::abs(b)) ? bit : 0;
  }
  unsigned operator()(const RasterPoint& p) const {
    return Below(p.x, x0 * p.w, 1) | Below(x1 * p.w, p.x, 2) | Below(p.y, y0 * p.w, 4) |
           Below(y1 * p.w, p.y, 8) | Below(p.w, p.z, 16) | Below(p.z, far_depth * p.w, 32);
  }
};

}  // namespace

TileFrustum::TileFrustum(const FrameView& view, const TileRect& rect, double scale)
    : x0_(rect.x),
      x1_(double(rect.x) + rect.width),
      y0_(rect.y),
      y1_(double(rect.y) + rect.height),
      far_depth_(view.FarDepth()) {
  // A border of the rectangle, ±(X - border w) >= 0, with X and w as FrameView defines them; everything
  // divided by the scale.
  const auto border = [&](double sign, const V3d& axis, double centre_minus_border) {
    Plane plane;
    plane.normal = axis * sign;
    if (view.perspective) {
      plane.normal.z -= sign * centre_minus_border;
    } else {
      plane.offset = sign * centre_minus_border / scale;
    }
    return plane;
  };
  const V3d x_axis(view.scale_x, 0, 0), y_axis(0, -view.scale_y, 0);
  planes_[0] = border(1, x_axis, view.center_x - x0_);
  planes_[1] = border(-1, x_axis, view.center_x - x1_);
  planes_[2] = border(1, y_axis, view.center_y - y0_);
  planes_[3] = border(-1, y_axis, view.center_y - y1_);
  planes_[4] = {V3d(0, 0, -1), -view.znear / scale};
  planes_[5] = view.zfar > 0 ? Plane{V3d(0, 0, 1), view.zfar / scale} : Plane{V3d(0, 0, 0), 1};
}

TileFrustum::Side TileFrustum::ClassifyBox(const ViewBounds& box) const {
  Side side = Side::kInside;
  for (const Plane& plane : planes_) {
    // The plane's largest and smallest value over the box, each at one of its corners.
    double largest = plane.offset, smallest = plane.offset, magnitude = std::abs(plane.offset);
    for (int axis = 0; axis < 3; ++axis) {
      const double a = plane.normal[axis] * double(box.lower[axis]);
      const double b = plane.normal[axis] * double(box.upper[axis]);
      largest += a > b ? a : b;
      smallest += a > b ? b : a;
      magnitude += std::max(std::abs(a), std::abs(b));
    }
    if (largest < -kRounding * magnitude) return Side::kOutside;
    if (smallest < 0) side = Side::kCrossing;
  }
  return side;
}

bool TileFrustum::MayContain(std::span<const RasterPoint> points) const {
  const OutsideOf outside_of{x0_, x1_, y0_, y1_, far_depth_};
  unsigned outside_of_all = ~0u;
  for (const RasterPoint& point : points) {
    outside_of_all &= outside_of(point);
    if (outside_of_all == 0) return true;
  }
  return false;
}

}  // namespace shutterline::engine
