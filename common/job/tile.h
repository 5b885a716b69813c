#pragma once

#include <cstdint>

namespace shutterline {

/// Width and height of the tiles that a frame is split into, in pixels. Part of the EXR's tile
/// description and of the protocol; the engine itself takes rectangles of any size.
inline constexpr int kTileSize = 32;

/// A rectangle of pixels: [x, x + width) × [y, y + height), raster space, y down.
struct TileRect {
  int x = 0, y = 0, width = 0, height = 0;

  int64_t Area() const { return int64_t{width} * height; }
  friend bool operator==(const TileRect&, const TileRect&) = default;
};

/// How a frame of `width` × `height` pixels is cut into tiles, in rows from the top left. Tiles in the
/// last column and row are cut at the frame's border.
struct TileGrid {
  int width = 0, height = 0;

  int Columns() const { return (width + kTileSize - 1) / kTileSize; }
  int Rows() const { return (height + kTileSize - 1) / kTileSize; }
  int Count() const { return Columns() * Rows(); }

  /// The pixels of tile `index`, 0 <= index < Count().
  TileRect Rect(int index) const {
    const int x = index % Columns() * kTileSize;
    const int y = index / Columns() * kTileSize;
    return {x, y, width - x < kTileSize ? width - x : kTileSize,
            height - y < kTileSize ? height - y : kTileSize};
  }
};

}  // namespace shutterline
