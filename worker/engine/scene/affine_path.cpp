#include "worker/engine/scene/affine_path.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "common/math/tolerance.h"

namespace shutterline::engine {
namespace {

/// Of what is computed vertex by vertex, relative to the sum of the absolute values of all terms: some twenty
/// roundings of 2^-53, enlarged by the coefficients that make control points (InterpolateBezier), with much
/// room.
constexpr double kRounding = 4096 * std::numeric_limits<double>::epsilon();
/// The bound must keep this much below the tolerance.
constexpr double kSlack = 0.999;

/// A linear function of (x, y, z, 1).
struct Linear {
  std::array<double, 4> c{};

  void Add(double factor, const Linear& other) {
    for (size_t i = 0; i < 4; ++i) c[i] += factor * other.c[i];
  }
  double At(const V3d& p) const { return c[0] * p.x + c[1] * p.y + c[2] * p.z + c[3]; }
  /// How far it may be, within a box about the origin with these half sides, from its value there.
  double Reach(const V3d& half) const {
    return std::abs(c[0]) * half.x + std::abs(c[1]) * half.y + std::abs(c[2]) * half.z;
  }
  double LargestIn(const V3d& centre, const V3d& half) const { return std::abs(At(centre)) + Reach(half); }
};

/// Homogeneous raster coordinates of an affine map's points, and the sum of the magnitudes that they come
/// from.
struct RasterMap {
  Linear x, y, z, w;
  double magnitude = 0;

  void Add(double factor, const RasterMap& other) {
    x.Add(factor, other.x);
    y.Add(factor, other.y);
    z.Add(factor, other.z);
    w.Add(factor, other.w);
    magnitude += std::abs(factor) * other.magnitude;
  }
};

/// `most` are the largest absolute coordinates of points that are looked at.
RasterMap RasterFrom(const FrameView& view, const M44d& m, const V3d& most) {
  std::array<Linear, 3> axes;
  std::array<double, 3> sizes{};
  for (size_t axis = 0; axis < 3; ++axis) {
    for (size_t row = 0; row < 4; ++row) {
      axes[axis].c[row] = m[int(row)][int(axis)];
      sizes[axis] += std::abs(axes[axis].c[row]) * (row < 3 ? most[int(row)] : 1);
    }
  }
  const Linear one{{0, 0, 0, 1}};
  RasterMap map;
  map.w.Add(view.perspective ? -1 : 1, view.perspective ? axes[2] : one);
  map.x.Add(view.scale_x, axes[0]);
  map.x.Add(view.center_x, map.w);
  map.y.Add(-view.scale_y, axes[1]);
  map.y.Add(view.center_y, map.w);
  const double w_size = view.perspective ? sizes[2] : 1;
  map.magnitude = std::max({view.scale_x * sizes[0] + std::abs(view.center_x) * w_size,
                            view.scale_y * sizes[1] + std::abs(view.center_y) * w_size, w_size});
  if (view.perspective) {
    map.z.Add(view.znear, one);
  } else {
    const double range = view.zfar - view.znear;
    map.z.Add(view.zfar / range, one);
    map.z.Add(1 / range, axes[2]);
    map.magnitude = std::max(map.magnitude, (std::abs(view.zfar) + sizes[2]) / range);
  }
  return map;
}

/// What the value at i / degree counts for the value at u, on a curve through values at equal intervals.
double Weight(size_t degree, size_t i, double u) {
  double weight = 1;
  for (size_t k = 0; k <= degree; ++k) {
    if (k != i) weight *= (u * double(degree) - double(k)) / (double(i) - double(k));
  }
  return weight;
}

}  // namespace

bool AffinePathIsFollowed(const FrameView& view, const Box3d& box, std::span<const M44d* const> knots,
                          double u, const M44d& path) {
  if (box.isEmpty() || knots.size() < 2) return false;
  const V3d centre = 0.5 * (box.min + box.max);
  const V3d half = 0.5 * (box.max - box.min);
  const V3d most(std::abs(centre.x) + half.x, std::abs(centre.y) + half.y, std::abs(centre.z) + half.z);
  const RasterMap true_map = RasterFrom(view, path, most);
  RasterMap difference;
  difference.Add(-1, true_map);
  for (size_t i = 0; i < knots.size(); ++i) {
    difference.Add(Weight(knots.size() - 1, i, u), RasterFrom(view, *knots[i], most));
  }
  const double rounding = kRounding * difference.magnitude;
  const double w_change = difference.w.LargestIn(centre, half) + rounding;
  const double z_change = difference.z.LargestIn(centre, half) + rounding;

  // All of the box is in front of the near plane, on the path and on the curve.
  Linear before_near = true_map.w;
  before_near.Add(-1, true_map.z);
  if (!(before_near.At(centre) - before_near.Reach(half) > w_change + z_change)) return false;
  const double least_w = true_map.w.At(centre) - true_map.w.Reach(half) - w_change;
  if (!(least_w > 0)) return false;
  const double depth = view.perspective ? w_change / least_w : z_change;
  if (!(depth <= kSlack * kPathDepth)) return false;

  // With X = x / w on the path, the curve is (dx - X dw) / (w + dw) beside it; X is near that of the centre.
  double square = 0;
  for (const bool is_y : {false, true}) {
    const Linear& position = is_y ? true_map.y : true_map.x;
    const double middle = position.At(centre) / true_map.w.At(centre);
    Linear spread = position;
    spread.Add(-middle, true_map.w);
    Linear beside = is_y ? difference.y : difference.x;
    beside.Add(-middle, difference.w);
    const double away = (spread.Reach(half) + rounding) / least_w;
    const double change =
        beside.LargestIn(centre, half) + away * w_change + (1 + std::abs(middle) + away) * rounding;
    square += change * change;
  }
  return std::sqrt(square) <= kSlack * kPathPixels * least_w;
}

}  // namespace shutterline::engine
