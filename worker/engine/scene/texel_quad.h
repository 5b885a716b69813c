#pragma once

#include <cstdint>

namespace shutterline::engine {

/// A bilinear look at a level of a pyramid. Rows of texels follow one another without gaps, so a texel's
/// number is y * width + x; where an image ends or repeats, the four need not be neighbours. Left without
/// initial values, as looks are made by the dozen a point.
struct TexelQuad {
  uint32_t top_left, top_right, bottom_left, bottom_right;  ///< Numbers of texels.
  float right, down;  ///< How far the place is from the left ones to the right ones, from top to bottom.
};

}  // namespace shutterline::engine
