#include "common/job/tile.h"

#include <gtest/gtest.h>

#include <vector>

namespace shutterline {
namespace {

TEST(TileGrid, CoversEveryPixelOnce) {
  for (const auto& [width, height] : {std::pair{1, 1}, {32, 32}, {33, 31}, {65, 97}, {31, 200}}) {
    const TileGrid grid{width, height};
    std::vector<int> seen(size_t(width * height));
    for (int i = 0; i < grid.Count(); ++i) {
      const TileRect rect = grid.Rect(i);
      EXPECT_GE(rect.Area(), 1);
      EXPECT_LE(rect.width, kTileSize);
      EXPECT_LE(rect.height, kTileSize);
      for (int y = rect.y; y < rect.y + rect.height; ++y) {
        for (int x = rect.x; x < rect.x + rect.width; ++x) seen.at(size_t(y * width + x))++;
      }
    }
    EXPECT_EQ(seen, std::vector<int>(seen.size(), 1));
  }
}

}  // namespace
}  // namespace shutterline
