#pragma once

#include <algorithm>
#include <cmath>

#include "common/math/spaces.h"

/// The microfacet model that glTF's metallic-roughness materials are defined by [walter2007, heitz2014].
/// Cosines are those of angles to the normal (N), the viewer (V), the light (L) and the half vector (H).
namespace shutterline::engine {

/// Of α, the square of a material's roughness: below it highlights of point lights would be points.
inline constexpr double kLeastAlpha = 1e-3;

/// The density of facets whose normal is the half vector, per steradian.
inline double GgxDistribution(double n_dot_h, double alpha) {
  const double a2 = alpha * alpha;
  const double d = n_dot_h * n_dot_h * (a2 - 1) + 1;
  return a2 / (M_PI * d * d);
}

/// Smith's height-correlated share of facets seen by both, over 4 (N·L) (N·V).
inline double SmithVisibility(double n_dot_v, double n_dot_l, double alpha) {
  const double a2 = alpha * alpha;
  const double v = n_dot_l * std::sqrt(n_dot_v * n_dot_v * (1 - a2) + a2);
  const double l = n_dot_v * std::sqrt(n_dot_l * n_dot_l * (1 - a2) + a2);
  return v + l > 0 ? 0.5 / (v + l) : 0;
}

/// Schlick's reflectance between `f0`, head-on, and `f90`, grazing.
inline V3d SchlickFresnel(const V3d& f0, double f90, double v_dot_h) {
  const double c = std::clamp(1 - v_dot_h, 0.0, 1.0);
  const double c2 = c * c;
  return f0 + (V3d(f90) - f0) * (c2 * c2 * c);
}

}  // namespace shutterline::engine
