#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "common/image/image.h"
#include "common/job/tile.h"

namespace shutterline::bench {

/// The tiles of a frame that are measured: of every square of `side` × `side` tiles one, at random. Time and
/// error are taken over the same tiles, so the two belong together; a frame's time is estimated as set-up +
/// tiles' time × tiles of the frame / tiles measured.
struct TileSubset {
  std::vector<TileRect> tiles;
  int tiles_in_frame = 0;
  int side = 1;

  double Share() const { return double(tiles.size()) / tiles_in_frame; }
};

/// `side` 1: the whole frame. Equal arguments give equal tiles. Frames whose sides are multiples of
/// kTileSize only (all tiles are whole).
TileSubset StratifiedTiles(int width, int height, int side, uint64_t seed);

/// Tiles as one picture, one below the other.
Image StackedImage(const TileSubset& subset);
/// Tile `index` of a stack, as a picture of its own.
Image TileOf(const Image& stack, int index);

/// Calls work(index, thread) for 0 <= index < count, each once, on `threads` threads.
void ParallelFor(int count, int threads, const std::function<void(int index, int thread)>& work);

}  // namespace shutterline::bench
