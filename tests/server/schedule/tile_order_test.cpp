#include "server/schedule/tile_order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <numeric>

namespace shutterline::server {
namespace {

TEST(TileOrderTest, EveryTileOnceForAnyGrid) {
  for (const auto& [columns, rows] : {std::pair{1, 1}, {1, 9}, {7, 1}, {5, 3}, {32, 24}, {33, 17}}) {
    std::vector<uint32_t> order = HilbertOrder(columns, rows);
    std::sort(order.begin(), order.end());
    std::vector<uint32_t> all(size_t(columns * rows));
    std::iota(all.begin(), all.end(), 0u);
    EXPECT_EQ(order, all) << columns << "x" << rows;
  }
}

TEST(TileOrderTest, NeighboursOnTheCurveTouchOnASquareOfAPowerOfTwo) {
  const int side = 16;
  const std::vector<uint32_t> order = HilbertOrder(side, side);
  for (size_t i = 1; i < order.size(); ++i) {
    const int dx = int(order[i]) % side - int(order[i - 1]) % side;
    const int dy = int(order[i]) / side - int(order[i - 1]) / side;
    EXPECT_EQ(std::abs(dx) + std::abs(dy), 1) << "at step " << i;
  }
}

}  // namespace
}  // namespace shutterline::server
