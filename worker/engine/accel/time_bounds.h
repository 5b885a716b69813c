#pragma once

#include <array>

#include "common/math/spaces.h"

namespace shutterline::engine {

/// A rectangle of the raster between the near and the far plane, in homogeneous raster space.
struct RasterBox {
  double x0 = 0, x1 = 0, y0 = 0, y1 = 0;  ///< Pixels.
  double far_depth = 0;
};

/// Part of the shutter; empty where in > out.
struct TimeInterval {
  double in = 1, out = 0;

  bool IsEmpty() const { return !(in <= out); }
};

/// Conservative bounds of the instants at which a moving triangle may be inside `box`: outside of the
/// interval, all three vertices lie outside of one and the same of its planes. `points[i]` are the
/// pieces * degree + 1 control points of corner i.
///
/// A vertex's signed distance from a plane through the eye is a Bezier polynomial, whose coefficients are the
/// distances of its control points [gribel2013, section 4.2]. Each piece of a curve is cut into four, and of
/// each part the hull of the coefficients is cut with zero; departs from the slefes of the paper, over which
/// cutting has the merit that all planes are looked at together, in each part of the shutter. Straight pieces
/// are solved exactly.
TimeInterval TimesInside(const std::array<const RasterPoint*, 3>& points, int degree, int pieces,
                         const RasterBox& box);

}  // namespace shutterline::engine
