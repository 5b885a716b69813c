#pragma once

#include <cstdint>
#include <vector>

namespace shutterline::server {

/// The tiles of a grid along a Hilbert curve: index `row * columns + column` of each tile, each once. Any run
/// of the curve is compact, so the tiles of a lease share what a worker culls and caches for them.
std::vector<uint32_t> HilbertOrder(int columns, int rows);

}  // namespace shutterline::server
