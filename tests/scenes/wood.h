#pragma once

#include "tests/scenes/surface_map.h"

namespace shutterline::scenes {

/// A kind of wood: the colours of early and late wood and of its pores, sRGB.
struct WoodKind {
  V3f early, late, pores;
  int rings = 10;          ///< Across the picture.
  double contrast = 1;     ///< Of the rings.
  double roughness = 0.4;  ///< Of early wood; late wood is smoother, pores are rougher.
};

WoodKind Maple();
WoodKind Walnut();
WoodKind Mahogany();
WoodKind Rosewood();

/// A board sawn along the trunk: the grain runs down the picture.
SurfaceMap Wood(int size, const WoodKind& kind, uint32_t seed);

}  // namespace shutterline::scenes
