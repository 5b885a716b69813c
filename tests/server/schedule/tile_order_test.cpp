#include "server/schedule/tile_order.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <numeric>
#include <random>

namespace shutterline::server {
namespace {

using testing::ElementsAre;

constexpr TileOrder kOrders[] = {TileOrder::kHilbert, TileOrder::kCenter, TileOrder::kCoarse};

struct Grid {
  int columns = 0, rows = 0;
};

/// Of every kind, and forty more at random.
std::vector<Grid> Grids() {
  std::vector<Grid> grids = {{1, 1}, {1, 2}, {1, 9}, {7, 1},   {64, 1},
                             {5, 3}, {8, 8}, {9, 9}, {32, 24}, {33, 17}};
  std::mt19937 random(1);
  for (int i = 0; i < 40; ++i) grids.push_back({1 + int(random() % 70), 1 + int(random() % 40)});
  return grids;
}

/// A king's moves from one tile to another.
int Moves(const Grid& grid, uint32_t a, uint32_t b) {
  const int dx = int(a) % grid.columns - int(b) % grid.columns,
            dy = int(a) / grid.columns - int(b) / grid.columns;
  return std::max(std::abs(dx), std::abs(dy));
}

TEST(TileOrderTest, WordsGoBothWays) {
  for (const TileOrder order : kOrders) EXPECT_EQ(ParseTileOrder(ToString(order)), order);
  for (const char* word : {"", "Hilbert", "centre", "coarse "}) EXPECT_EQ(ParseTileOrder(word), std::nullopt);
}

TEST(TileOrderTest, EveryTileOnceForAnyGridAndOrder) {
  for (const Grid& grid : Grids()) {
    std::vector<uint32_t> all(size_t(grid.columns * grid.rows));
    std::iota(all.begin(), all.end(), 0u);
    for (const TileOrder order : kOrders) {
      std::vector<uint32_t> tiles = OrderTiles(order, grid.columns, grid.rows);
      std::sort(tiles.begin(), tiles.end());
      EXPECT_EQ(tiles, all) << grid.columns << "x" << grid.rows << " " << ToString(order);
    }
  }
}

TEST(TileOrderTest, NeighboursOnTheCurveTouchOnASquareOfAPowerOfTwo) {
  const int side = 16;
  const std::vector<uint32_t> order = OrderTiles(TileOrder::kHilbert, side, side);
  for (size_t i = 1; i < order.size(); ++i) {
    const int dx = int(order[i]) % side - int(order[i - 1]) % side;
    const int dy = int(order[i]) / side - int(order[i - 1]) / side;
    EXPECT_EQ(std::abs(dx) + std::abs(dy), 1) << "at step " << i;
  }
}

TEST(TileOrderTest, CenterWalksRoundRings) {
  EXPECT_THAT(OrderTiles(TileOrder::kCenter, 3, 3), ElementsAre(4, 0, 1, 2, 5, 8, 7, 6, 3));
  EXPECT_THAT(OrderTiles(TileOrder::kCenter, 4, 2), ElementsAre(1, 2, 6, 5, 3, 7, 4, 0));
  EXPECT_THAT(OrderTiles(TileOrder::kCenter, 1, 5), ElementsAre(2, 1, 3, 0, 4));
}

TEST(TileOrderTest, CenterGoesNeverBackTowardsTheMiddle) {
  for (const Grid& grid : Grids()) {
    // The middle tile, or the two or four that touch the middle.
    std::vector<uint32_t> middle;
    for (const int y : {(grid.rows - 1) / 2, grid.rows / 2}) {
      for (const int x : {(grid.columns - 1) / 2, grid.columns / 2})
        middle.push_back(uint32_t(y * grid.columns + x));
    }
    int before = 0;
    for (const uint32_t tile : OrderTiles(TileOrder::kCenter, grid.columns, grid.rows)) {
      int moves = 1000;
      for (const uint32_t from : middle) moves = std::min(moves, Moves(grid, tile, from));
      ASSERT_GE(moves, before) << grid.columns << "x" << grid.rows << " tile " << tile;
      before = moves;
    }
  }
}

/// The promise of a preview: it is all over the frame at once, and no tile waits far from one that is there.
TEST(TileOrderTest, CoarseCoversTheFrameStepByStep) {
  for (const Grid& grid : Grids()) {
    const std::vector<uint32_t> order = OrderTiles(TileOrder::kCoarse, grid.columns, grid.rows);
    const auto covers = [&](size_t first, int moves) {
      for (uint32_t tile = 0; tile < order.size(); ++tile) {
        const auto near = [&](uint32_t there) { return Moves(grid, tile, there) <= moves; };
        ASSERT_TRUE(std::any_of(order.begin(), order.begin() + std::ptrdiff_t(first), near))
            << grid.columns << "x" << grid.rows << ": tile " << tile << " after " << first;
      }
    };
    const auto steps = [](int count, int step) { return (count + step - 1) / step; };
    covers(size_t(steps(grid.columns, 8) * steps(grid.rows, 8)), 4);
    // Where the first lie decides whether there is one more or one fewer of the next.
    covers(std::min(order.size(), size_t((steps(grid.columns, 4) + 1) * (steps(grid.rows, 4) + 1))), 3);
    covers(std::min(order.size(), size_t((steps(grid.columns, 2) + 1) * (steps(grid.rows, 2) + 1))), 1);
  }
}

TEST(TileOrderTest, CoarseBeginsWithAnEvenLattice) {
  const std::vector<uint32_t> order = OrderTiles(TileOrder::kCoarse, 20, 12);
  // 20 columns: 1, 9, 17 and 2 left over; 12 rows: 1, 9 and 2 left over.
  EXPECT_THAT(std::vector<uint32_t>(order.begin(), order.begin() + 6),
              testing::UnorderedElementsAre(1 * 20 + 1, 1 * 20 + 9, 1 * 20 + 17, 9 * 20 + 1, 9 * 20 + 9,
                                            9 * 20 + 17));
}

}  // namespace
}  // namespace shutterline::server
