#pragma once

#include <array>
#include <optional>

#include "common/math/spaces.h"
#include "worker/engine/shading/barycentric.h"
#include "worker/engine/shading/texel.h"

namespace shutterline::engine {

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

 private:
  std::optional<TexelLevels> LevelsOf(const Barycentric& at) const;

  bool is_uniform_ = false;
  TexelLevels uniform_;  ///< If they are the same at the corners and in the middle, they are everywhere.
  V2d rise1_{0, 0}, rise2_{0, 0}, rise_sum_{0, 0};  ///< ∇r_1, ∇r_2, ∇s, over the rate; zeros: edge-on.
  double w0_ = 0, w1_ = 0, w2_ = 0;                 ///< w, and what it gains towards corners 1 and 2.
};

}  // namespace shutterline::engine
