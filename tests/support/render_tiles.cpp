#include "tests/support/render_tiles.h"

#include <algorithm>
#include <atomic>
#include <mutex>
#include <span>
#include <thread>
#include <vector>

namespace shutterline::engine {

Image RenderRect(const TileIntegrator& integrator, const TileRect& rect, RenderStats* stats) {
  Image image(rect.width, rect.height);
  RenderStats unused;
  integrator.Render(rect, image.values(), stats != nullptr ? *stats : unused);
  return image;
}

Image RenderTiles(const TileIntegrator& integrator, int width, int height, int tile_width, int tile_height,
                  int threads, RenderStats* stats) {
  return RenderWindow(integrator, {0, 0, width, height}, tile_width, tile_height, threads, stats);
}

Image RenderWindow(const TileIntegrator& integrator, const TileRect& window, int tile_width, int tile_height,
                   int threads, RenderStats* stats) {
  std::vector<TileRect> tiles;
  for (int y = 0; y < window.height; y += tile_height) {
    for (int x = 0; x < window.width; x += tile_width) {
      tiles.push_back({window.x + x, window.y + y, std::min(tile_width, window.width - x),
                       std::min(tile_height, window.height - y)});
    }
  }
  Image image(window.width, window.height);
  std::atomic<int> left = int(tiles.size());
  std::mutex mutex;
  RenderStats sum;
  const auto work = [&] {
    RenderStats own;
    for (int i = --left; i >= 0; i = --left) {
      const TileRect& tile = tiles[size_t(i)];
      const Image part = RenderRect(integrator, tile, &own);
      for (int y = 0; y < tile.height; ++y) {
        std::copy_n(part.At(0, y), 4 * tile.width, image.At(tile.x - window.x, tile.y - window.y + y));
      }
    }
    const std::lock_guard lock(mutex);
    sum += own;
  };
  std::vector<std::jthread> workers;
  for (int i = 1; i < threads; ++i) workers.emplace_back(work);
  work();
  workers.clear();  // Joins.
  if (stats != nullptr) *stats += sum;
  return image;
}

}  // namespace shutterline::engine
