#pragma once

#include <array>

#include "common/math/spaces.h"

namespace shutterline::engine {

/// Whether a moving triangle shows its back at every instant of the shutter, by more than rounding; nothing
/// of it is then seen where its material is culled from behind. `points[i]` are the pieces * degree + 1
/// control points of corner i.
///
/// The triangle's facing is the sign of the determinant of its corners (x, y, w), which holds in front of the
/// eye and behind it. Of Bezier corners that is a polynomial of three times the degree, whose
/// coefficients in Bernstein form bound it.
bool ShowsItsBackAlways(const std::array<const RasterPoint*, 3>& points, int degree, int pieces);

}  // namespace shutterline::engine
