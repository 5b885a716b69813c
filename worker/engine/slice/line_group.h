#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/job/tile.h"
#include "worker/engine/sampling/line_pattern.h"

namespace shutterline::engine {

/// Lines that are resolved in lockstep, one a vector lane. Fixed, whatever the width of the machine's
/// vectors, so that it cannot show in the picture.
inline constexpr int kLanes = 16;

/// Up to kLanes neighbouring lines of a family that lie one pixel apart and share their instants: the lines
/// of one class of InstantOffset. At each of these instants the triangles are set up once for all of them.
///
/// Line coordinates: `row` = minor − slope · major − intercept, so that lane i is where row = i, and
/// `position` along the major axis, both in pixels relative to the tile.
struct LineGroup {
  int family = 0;
  bool major_is_x = true;
  double slope = 0;
  double intercept = 0;  ///< Of lane 0.
  double instant_offset = 0.5;
  int lanes = 0;
  std::array<TileLine, kLanes> lines{};
  /// The part of each line within the tile, subpixels; empty beyond `lanes`, with room to read a vector past
  /// the last.
  alignas(64) std::array<int32_t, 2 * kLanes> begin{}, end{};
};

/// Splits the pattern's lines in `rect` into groups. Replaces `groups`.
void GroupLines(const LinePattern& pattern, const TileRect& rect, std::vector<LineGroup>& groups);

}  // namespace shutterline::engine
