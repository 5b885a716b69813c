#pragma once

#include <array>
#include <optional>

#include "common/math/spaces.h"
#include "worker/engine/shading/barycentric.h"
#include "worker/engine/shading/texel.h"

namespace shutterline::engine {

/// The least square of a pixel's part of a triangle's side, times the rate, that a level serves.
inline constexpr double kLeastTexelRise = 0x1p-62;

/// Which levels of texels serve the points of a projected triangle: LevelsAt of a pixel's footprint there, in
/// a form that is quick to ask point by point.
///
/// Over the raster plane, barycentric coordinates times 1/w and 1/w itself are linear; so with r_i the rows
/// of the inverse of the matrix of the corners (x, y, w) and s their sum, ∇b_i = w (∇r_i − b_i ∇s), without a
/// division.
class TexelLevelsOfTriangle {
 public:
  TexelLevelsOfTriangle() = default;
  /// `corners` in homogeneous raster space. Texels are about 1 / rate pixels wide.
  TexelLevelsOfTriangle(const std::array<RasterPoint, 3>& corners, double rate);

  /// Nothing where the point is not in front of the camera, the triangle is seen edge-on, or texels would be
  /// too fine for a key.
  std::optional<TexelLevels> At(const Barycentric& at) const {
    if (is_uniform_) return uniform_;
    return LevelsOf(at);
  }

  /// Are the levels the same all over the triangle?
  bool is_uniform() const { return is_uniform_; }
  /// If so: its columns and rows.
  double columns() const { return columns_; }
  double rows() const { return rows_; }
  /// Is it all one texel?
  bool IsOneTexel() const { return is_uniform_ && uniform_ == TexelLevels{}; }

  /// How fast b1 and b2 change from pixel to pixel, in a form that needs no division: with 1/w at the shutter
  /// time at which the point is seen, w here and the squares are to be multiplied by that time's w and by
  /// (w · w of that time)² in turn.
  struct Rise {
    double w, squared1, squared2;
  };
  /// `b1_w` and `b2_w`: coordinates of a point over a w of its own; `one_w`: 1 over that.
  Rise RiseAt(double b1_w, double b2_w, double one_w) const {
    const V2d along1 = one_w * rise1_ - b1_w * rise_sum_, along2 = one_w * rise2_ - b2_w * rise_sum_;
    return {one_w * w0_ + b1_w * w1_ + b2_w * w2_, along1.length2(), along2.length2()};
  }

 private:
  std::optional<TexelLevels> LevelsOf(const Barycentric& at) const;

  bool is_uniform_ = false;
  double columns_ = 0, rows_ = 0;
  TexelLevels uniform_;  ///< If they are the same at the corners and in the middle, they are everywhere.
  V2d rise1_{0, 0}, rise2_{0, 0}, rise_sum_{0, 0};  ///< ∇r_1, ∇r_2, ∇s, over the rate; zeros: edge-on.
  double w0_ = 0, w1_ = 0, w2_ = 0;                 ///< w, and what it gains towards corners 1 and 2.
};

}  // namespace shutterline::engine
