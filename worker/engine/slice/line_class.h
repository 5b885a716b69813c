#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/job/tile.h"
#include "worker/engine/sampling/line_pattern.h"

namespace shutterline::engine {

/// Lines that are resolved in lockstep, one a vector lane. Fixed, whatever the width of the machine's
/// vectors, so that it cannot show in the picture.
inline constexpr int kLanes = 16;

/// Up to kLanes neighbouring lines of a class: lane i is the class's row first_row + i.
struct LineGroup {
  int first_row = 0;
  int lanes = 0;
  /// The part of each line within the tile, subpixels; empty beyond `lanes`, with room to read a vector past
  /// the last.
  alignas(64) std::array<int32_t, 2 * kLanes> begin{}, end{};
};

/// Where a class's lines lie: coordinates in which they are rows. `row` = minor − slope · major − intercept,
/// so that line i of the class is where row = i; `position` runs along the major axis. Pixels relative to the
/// tile.
struct LineAxes {
  bool major_is_x = true;
  double slope = 0;
  double intercept = 0;
};

/// The lines of a family that lie one pixel apart in a tile. They have the same place within their pixels,
/// hence the same InstantOffset and the same instants: at each of these the triangles are placed once for
/// all of them.
struct LineClass {
  int family = 0;
  LineAxes axes;
  double instant_offset = 0.5;
  int lines_per_pixel = 1;      ///< Of the family.
  int length = 0;               ///< Of the tile along the major axis, pixels.
  std::vector<TileLine> lines;  ///< By row.
  std::vector<LineGroup> groups = {};
  std::vector<int32_t> pixels = {};  ///< See PixelOf.

  int rows() const { return int(lines.size()); }
  /// The pixel, counted in rows within the tile, that holds a step of a line, one of its own.
  int32_t PixelOf(int row, int step) const { return pixels[size_t(row) * size_t(length) + size_t(step)]; }
};

/// A pattern's lines in tiles. Tiles at the places of a frame's grid mostly have the same lines relative to
/// their corners: they are found once. Not thread-safe.
class TileLines {
 public:
  /// The classes of the lines in `rect`, valid until the next call.
  const std::vector<LineClass>& In(const LinePattern& pattern, const TileRect& rect);

 private:
  const LinePattern* pattern_ = nullptr;
  TileRect rect_;
  std::vector<LineClass> classes_;
};

}  // namespace shutterline::engine
