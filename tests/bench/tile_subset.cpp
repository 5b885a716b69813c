#include "tests/bench/tile_subset.h"

#include <algorithm>
#include <atomic>
#include <thread>

#include "common/base/check.h"
#include "tests/scenes/random.h"

namespace shutterline::bench {

TileSubset StratifiedTiles(int width, int height, int side, uint64_t seed) {
  SL_CHECK(width % kTileSize == 0 && height % kTileSize == 0 && side >= 1);
  const TileGrid grid{width, height};
  TileSubset subset{.tiles = {}, .tiles_in_frame = grid.Count(), .side = side};
  scenes::Random random(seed);
  for (int y = 0; y < grid.Rows(); y += side) {
    for (int x = 0; x < grid.Columns(); x += side) {
      const int column = x + random.Index(std::min(side, grid.Columns() - x));
      const int row = y + random.Index(std::min(side, grid.Rows() - y));
      subset.tiles.push_back(grid.Rect(row * grid.Columns() + column));
    }
  }
  return subset;
}

Image StackedImage(const TileSubset& subset) {
  return Image(kTileSize, kTileSize * int(subset.tiles.size()));
}

Image TileOf(const Image& stack, int index) {
  Image tile(kTileSize, kTileSize, stack.channels());
  std::copy_n(stack.At(0, index * kTileSize), tile.values().size(), tile.At(0, 0));
  return tile;
}

void ParallelFor(int count, int threads, const std::function<void(int, int)>& work) {
  std::atomic<int> next = 0;
  const auto run = [&](int thread) {
    for (int i = next++; i < count; i = next++) work(i, thread);
  };
  std::vector<std::jthread> workers;
  for (int i = 1; i < threads; ++i) workers.emplace_back(run, i);
  run(0);
}

}  // namespace shutterline::bench
