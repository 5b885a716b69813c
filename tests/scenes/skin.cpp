#include "tests/scenes/skin.h"

#include <algorithm>
#include <cmath>

#include "tests/scenes/noise.h"

namespace shutterline::scenes {

SurfaceMap Hide(int size, int plates, uint32_t seed) {
  const V3f sand = SrgbCode(0xcfa379), brown = SrgbCode(0x8a5a3a), rust = SrgbCode(0xa8522c),
            flesh = SrgbCode(0x573226), horn = SrgbCode(0xe6d0a8);
  return SurfaceMap(size, [&](double u, double v) {
    const double bend_u = 0.2 / plates * FractalNoise(u, v, plates, plates, 2, seed);
    const double bend_v = 0.2 / plates * FractalNoise(u, v, plates, plates, 2, seed + 5);
    const Cell cell = CellAt(u + bend_u, v + bend_v, plates, plates, seed + 10);
    const double to_edge = cell.second - cell.nearest;  // 0 between two plates.
    const double plate = SmoothStep(0.04, 0.2, to_edge);
    const double dome = std::max(0.0, 1 - cell.nearest * cell.nearest * 1.6);
    const double blotches = FractalNoise(u, v, 3, 3, 4, seed + 20);
    const double wrinkles = FractalNoise(u, v, 4 * plates, 4 * plates, 3, seed + 30);

    SurfacePoint point;
    point.color = Blend(sand, brown, 0.35 + 0.7 * blotches + 0.5 * (cell.number - 0.5));
    point.color = Blend(point.color, rust, 0.8 * SmoothStep(0.7, 1.0, cell.number));
    point.color = Blend(point.color, horn, 0.45 * SmoothStep(0.75, 1.0, dome) + 0.08 * wrinkles);
    point.color = Blend(flesh, point.color, 0.15 + 0.85 * plate);
    point.roughness = 0.8 - 0.28 * plate + 0.08 * wrinkles;
    point.height = (0.16 * plate + 0.16 * dome * plate + 0.025 * wrinkles) / plates;
    return point;
  });
}

}  // namespace shutterline::scenes
