#include "server/schedule/tile_order.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "common/base/check.h"

namespace shutterline::server {
namespace {

constexpr int kCoarsest = 8;  ///< Tiles from one of the first to the next.
/// Keys of tiles: what lies above these bits comes first.
constexpr int kWithinBits = 40;

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

/// How many steps a coordinate lies outside of the middle one or two of `count`.
int StepsFromMiddle(int at, int count) {
  return std::max({0, (count - 1) / 2 - at, at - count / 2});
}

/// The ring, and then how far round it, clockwise from its top left corner.
uint64_t CenterKey(int columns, int rows, int x, int y) {
  const int ring = std::max(StepsFromMiddle(x, columns), StepsFromMiddle(y, rows));
  const int left = (columns - 1) / 2 - ring, right = columns / 2 + ring;
  const int top = (rows - 1) / 2 - ring, bottom = rows / 2 + ring;
  int round = 0;
  if (y == top) {
    round = x - left;
  } else if (x == right) {
    round = (right - left) + (y - top);
  } else if (y == bottom) {
    round = (right - left) + (bottom - top) + (right - x);
  } else {
    round = 2 * (right - left) + (bottom - top) + (bottom - y);
  }
  return uint64_t(ring) << kWithinBits | uint64_t(round);
}

/// Where the first of every `kCoarsest` of `count` lies, so that what is left over at both ends is about
/// equal.
int CoarseOffset(int count) {
  const int between = (count - 1) / kCoarsest * kCoarsest;
  return (count - 1 - between) / 2;
}

/// 0 for the first tiles, 1 for those that halve their distances, and so on.
uint64_t CoarseLevel(int columns, int rows, int x, int y) {
  uint64_t level = 0;
  for (int step = kCoarsest; step > 1; step /= 2, ++level) {
    if ((x - CoarseOffset(columns)) % step == 0 && (y - CoarseOffset(rows)) % step == 0) break;
  }
  return level;
}

}  // namespace

std::vector<uint32_t> OrderTiles(TileOrder order, int columns, int rows) {
  SL_CHECK(columns > 0 && rows > 0);
  const uint32_t side = std::bit_ceil(uint32_t(std::max(columns, rows)));
  const auto key = [&](int x, int y) -> uint64_t {
    if (order == TileOrder::kCenter) return CenterKey(columns, rows, x, y);
    const uint64_t along = HilbertDistance(side, uint32_t(x), uint32_t(y));
    return order == TileOrder::kCoarse ? CoarseLevel(columns, rows, x, y) << kWithinBits | along : along;
  };
  std::vector<std::pair<uint64_t, uint32_t>> keyed;
  keyed.reserve(size_t(columns) * size_t(rows));
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < columns; ++x) keyed.emplace_back(key(x, y), uint32_t(y * columns + x));
  }
  std::sort(keyed.begin(), keyed.end());
  std::vector<uint32_t> tiles;
  tiles.reserve(keyed.size());
  for (const auto& [unused, tile] : keyed) tiles.push_back(tile);
  return tiles;
}

}  // namespace shutterline::server
