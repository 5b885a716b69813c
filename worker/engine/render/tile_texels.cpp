#include "worker/engine/render/tile_texels.h"

namespace shutterline::engine {

V3f TileTexels::At(uint32_t triangle, double b1, double b2) {
  if (!has_last_ || triangle != last_) {
    const auto [place, is_new] = corners_.try_emplace(triangle);
    if (is_new) place->second = shader_.CornersOf(triangle);
    corners_of_last_ = place->second;
    last_ = triangle;
    has_last_ = true;
  }
  return shader_.ShadeOnTexels(triangle, corners_of_last_, {b1, b2}, stats_).radiance;
}

}  // namespace shutterline::engine
