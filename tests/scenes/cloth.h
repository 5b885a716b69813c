#pragma once

#include <functional>

#include "tests/scenes/surface_map.h"

namespace shutterline::scenes {

/// A woven cloth: `threads` (a multiple of 4) either way in twill, each over two and under two of the
/// others. `color` says the colour (sRGB) of what lies on top where two threads cross: of the thread that
/// runs down the picture, or else of that across.
SurfaceMap Weave(int size, int threads, uint32_t seed,
                 const std::function<V3f(int column, int row, bool down)>& color);

/// A tartan, in which stripes of coloured thread cross; `threads` as for Weave. A repeat is the whole
/// picture.
SurfaceMap Tartan(int size, int threads, uint32_t seed);

/// Hangings: bands of lozenges between stripes of `figure` on `ground`.
SurfaceMap Banner(int size, int threads, const V3f& ground, const V3f& figure, uint32_t seed);

}  // namespace shutterline::scenes
