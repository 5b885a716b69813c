#pragma once

#include <cstdint>
#include <vector>

#include "common/job/tile_order.h"

namespace shutterline::server {

/// The tiles of a grid, index `row * columns + column` of each, each once:
///
/// - kHilbert: along a Hilbert curve. Any run of it is compact, so the tiles of a lease share what a worker
/// culls
///   and caches for them.
/// - kCenter: in rings around the middle tile (or the middle two or four), each ring walked round; rings that
///   leave the grid are cut.
/// - kCoarse: every 8th tile in both directions, then what every 4th tile adds, every 2nd, and all. Once the
/// first
///   are there no tile is further than 4 columns or rows from one of them, then 3, then 1. Tiles of one of
///   these levels follow the Hilbert curve, so that a lease is as compact as its level allows.
///
/// A function of its arguments alone. `columns` and `rows` are at least 1.
std::vector<uint32_t> OrderTiles(TileOrder order, int columns, int rows);

}  // namespace shutterline::server
