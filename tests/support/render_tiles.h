#pragma once

#include "common/image/image.h"
#include "common/job/tile.h"
#include "worker/engine/render/tile_integrator.h"

namespace shutterline::engine {

/// The pixels of `rect` as a picture of its size, rendered as one tile.
Image RenderRect(const TileIntegrator& integrator, const TileRect& rect, RenderStats* stats = nullptr);

/// A whole frame, cut into tiles of `tile_width` × `tile_height` pixels, which `threads` threads take from
/// the last to the first. Adds to `stats` where it is not null.
Image RenderTiles(const TileIntegrator& integrator, int width, int height, int tile_width = kTileSize,
                  int tile_height = kTileSize, int threads = 1, RenderStats* stats = nullptr);

/// The same for a part of a frame.
Image RenderWindow(const TileIntegrator& integrator, const TileRect& window, int tile_width = kTileSize,
                   int tile_height = kTileSize, int threads = 1, RenderStats* stats = nullptr);

}  // namespace shutterline::engine
