#pragma once

#include "tests/scenes/surface_map.h"

namespace shutterline::scenes {

/// A kind of marble, sRGB: the stone, the clouds in it and its veins.
struct MarbleKind {
  V3f stone, clouds, veins;
  double veining = 1;       ///< 0: none, 1: plenty.
  double roughness = 0.18;  ///< Polished.
};

MarbleKind WhiteMarble();
MarbleKind CreamMarble();
MarbleKind GreenMarble();

/// How polished marble looks at (u, v) of the unit square, which it tiles.
SurfacePoint MarbleAt(const MarbleKind& kind, double u, double v, uint32_t seed);

SurfaceMap Marble(int size, const MarbleKind& kind, uint32_t seed);

/// Squares of two kinds of marble in turn, `squares` (even) a side, joined by fine grooves.
SurfaceMap MarbleChecker(int size, const MarbleKind& first, const MarbleKind& second, int squares,
                         uint32_t seed);

}  // namespace shutterline::scenes
