#pragma once

#include "tests/scenes/surface_map.h"

namespace shutterline::scenes {

/// Skin of horny plates, `plates` × `plates` of them, each with a keel of its own tone, dark and soft skin
/// between them.
SurfaceMap Hide(int size, int plates, uint32_t seed);

}  // namespace shutterline::scenes
