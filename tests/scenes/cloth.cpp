#include "tests/scenes/cloth.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "common/base/check.h"
#include "tests/scenes/noise.h"

namespace shutterline::scenes {

SurfaceMap Weave(int size, int threads, uint32_t seed,
                 const std::function<V3f(int column, int row, bool down)>& color) {
  SL_CHECK(threads > 0 && threads % 4 == 0);
  return SurfaceMap(size, [&](double u, double v) {
    const int column = int(std::floor(u * threads)), row = int(std::floor(v * threads));
    const double x = u * threads - column, y = v * threads - row;
    const int step = (column + row) % 4;
    const bool down = step < 2;
    // A thread is round across, and along it rises where it comes up between two others.
    const double across = 2 * (down ? x : y) - 1;
    const double round = std::sqrt(1 - 0.9 * across * across);
    const bool first = down ? step == 0 : step == 2;
    const double along = (first ? 0 : 1) + (down ? y : x);  // 0 to 2 over the two threads crossed.
    const double rise = 1 - (along - 1) * (along - 1);
    const int number = down ? column : row;
    const double own = HashOf(number, down ? 1 : 2, seed) - 0.5;
    const double fuzz = FractalNoise(u, v, 2 * threads, 2 * threads, 2, seed + 10);

    SurfacePoint point;
    const double light = 0.62 + 0.3 * round + 0.12 * rise + 0.16 * own + 0.08 * fuzz;
    point.color = color(column, row, down) * float(light);
    point.roughness = 0.85 + 0.08 * fuzz;
    point.height = (0.45 * round + 0.35 * rise + 0.08 * fuzz) / threads * 0.7;
    return point;
  });
}

SurfaceMap Tartan(int size, int threads, uint32_t seed) {
  const V3f red = SrgbCode(0xb81c30), navy = SrgbCode(0x18284f), gold = SrgbCode(0xf4c04a),
            cream = SrgbCode(0xf1e7d2), green = SrgbCode(0x1f5b45);
  // A stripe's colour and where it ends, in parts of the repeat.
  const std::pair<double, V3f> stripes[] = {{0.34, red},  {0.375, gold},  {0.41, red},   {0.56, navy},
                                            {0.6, green}, {0.64, cream},  {0.68, green}, {0.83, navy},
                                            {0.86, red},  {0.895, cream}, {1.0, red}};
  const auto thread = [&](int number) {
    for (const auto& [end, color] : stripes) {
      if (number + 0.5 < end * threads) return color;
    }
    return red;
  };
  return Weave(size, threads, seed,
               [&](int column, int row, bool down) { return thread(down ? column : row); });
}

SurfaceMap Banner(int size, int threads, const V3f& ground, const V3f& figure, uint32_t seed) {
  return Weave(size, threads, seed, [&](int column, int row, bool down) {
    // A quarter of the height is stripes, the rest two rows of lozenges, nested.
    const int stripes = threads / 4;
    bool on;
    if (row < stripes) {
      on = row % (stripes / 2) < stripes / 6 || (column / 2 % 4 == 0 && row > stripes / 2);
    } else {
      const int cell = threads / 4;
      const int dx = std::abs(2 * (column % cell) + 1 - cell),
                dy = std::abs(2 * ((row - stripes) % cell) + 1 - cell);
      const int ring = dx + dy;
      on = ring < cell / 3 || (ring > cell * 2 / 3 && ring < cell) || ring > cell * 17 / 10;
    }
    // Figures are of the threads across, which lie on top there as they do elsewhere, and shimmer so.
    const V3f color = on ? figure : ground;
    return down ? color * 0.92f : color;
  });
}

}  // namespace shutterline::scenes
