#pragma once

#include "tests/scenes/surface_map.h"

namespace shutterline::scenes {

/// Colours of a stone, sRGB: its least and most lit by nature, and what lies in its pits and joints.
struct StoneKind {
  V3f dark, light, joints;
  double roughness = 0.6;
};

StoneKind Travertine();
StoneKind RedLimestone();
StoneKind Sandstone();
StoneKind Slate();
StoneKind Terracotta();

/// `slabs` × `slabs` floor tiles, each of its own layers and tone, worn at the edges, joints between them.
SurfaceMap FloorTiles(int size, const StoneKind& kind, int slabs, uint32_t seed);

/// A wall of dressed blocks, `courses` (even) high, every second course shifted by half a block.
SurfaceMap Masonry(int size, const StoneKind& kind, int courses, uint32_t seed);

/// Natural rock without joints.
SurfaceMap Rock(int size, const StoneKind& kind, uint32_t seed);

/// Troweled lime plaster: patches, stains, fine cracks.
SurfaceMap Plaster(int size, const V3f& color, uint32_t seed);

}  // namespace shutterline::scenes
