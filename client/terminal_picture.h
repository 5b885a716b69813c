#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/job/tile.h"

namespace shutterline::client {

/// A frame as it fills, in a terminal of true colour: each character is two cells, one above the other. Tiles
/// that are not there are a dim chequer, or, where the picture is to be `coarse`, have the mean colour of the
/// nearest tile that is there, if one is within four columns and rows: frames that are rendered coarse to
/// fine are seen as a whole early, and sharpen. Not thread-safe.
class TerminalPicture {
 public:
  /// `grid` has at least one tile; it is shown as large as `columns` × `rows` characters allow, each at
  /// least 1.
  TerminalPicture(const TileGrid& grid, int columns, int rows, bool coarse = false);

  int columns() const { return columns_; }
  int rows() const { return cells_high_ / 2; }
  /// Means along each side of a tile that the picture can make use of: what ReadTiles is to be asked for.
  int tile_side() const { return side_; }

  /// `rgba`: tile_side() × tile_side() means, rows from the top, linear and premultiplied. False, and nothing
  /// is changed, where `tile` is not of the grid or `rgba` has another size.
  bool SetTile(uint32_t tile, std::span<const float> rgba);

  /// One string a row of characters, with colours, without newlines.
  std::vector<std::string> Lines() const;

 private:
  struct Colour {
    uint8_t r = 0, g = 0, b = 0;
    friend bool operator==(const Colour&, const Colour&) = default;
  };
  Colour CellColour(int x, int y) const;
  /// What stands in for a tile that is not there: the nearest one that is, of several the first; -1: none is
  /// near.
  int StandIn(int tile) const;

  const TileGrid grid_;
  const bool coarse_;
  int columns_ = 1, cells_high_ = 2;
  int side_ = 1;
  std::vector<std::vector<float>> tiles_;  ///< By tile; empty: not there.
  std::vector<Colour> means_;              ///< By tile, of those that are there.
};

}  // namespace shutterline::client
