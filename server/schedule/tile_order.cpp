#include "server/schedule/tile_order.h"

#include <algorithm>
#include <bit>
#include <utility>

namespace shutterline::server {
namespace {

/// Distance along the Hilbert curve that fills a square of `side` (a power of two) cells, at cell (x, y):
/// from the largest quadrants down, each quadrant turns the frame of those inside it.
uint64_t HilbertDistance(uint32_t side, uint32_t x, uint32_t y) {
  uint64_t distance = 0;
  for (uint32_t half = side / 2; half > 0; half /= 2) {
    const uint32_t right = (x & half) != 0 ? 1 : 0;
    const uint32_t upper = (y & half) != 0 ? 1 : 0;
    distance += uint64_t{half} * half * ((3 * right) ^ upper);
    if (upper == 0) {
      if (right == 1) {
        x = side - 1 - x;
        y = side - 1 - y;
      }
      std::swap(x, y);
    }
  }
  return distance;
}

}  // namespace

std::vector<uint32_t> HilbertOrder(int columns, int rows) {
  const uint32_t side = std::bit_ceil(uint32_t(std::max({columns, rows, 1})));
  std::vector<std::pair<uint64_t, uint32_t>> keyed;
  keyed.reserve(size_t(columns) * size_t(rows));
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < columns; ++x) {
      keyed.emplace_back(HilbertDistance(side, uint32_t(x), uint32_t(y)), uint32_t(y * columns + x));
    }
  }
  std::sort(keyed.begin(), keyed.end());
  std::vector<uint32_t> order;
  order.reserve(keyed.size());
  for (const auto& [distance, tile] : keyed) order.push_back(tile);
  return order;
}

}  // namespace shutterline::server
