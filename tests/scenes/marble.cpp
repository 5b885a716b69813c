#include "tests/scenes/marble.h"

#include <algorithm>
#include <cmath>

#include "common/base/check.h"
#include "tests/scenes/noise.h"

namespace shutterline::scenes {
namespace {

/// 1 on the lines where the noise is zero, down to 0 at `width` from them.
double Ridge(double noise, double width) {
  const double away = std::min(1.0, std::abs(noise) / width);
  return (1 - away) * (1 - away);
}

}  // namespace

MarbleKind WhiteMarble() {
  return {SrgbCode(0xf1eee8), SrgbCode(0xd3d1d0), SrgbCode(0x77777f), 1.0, 0.16};
}

MarbleKind CreamMarble() {
  return {SrgbCode(0xeadfc9), SrgbCode(0xd9c19c), SrgbCode(0x96714e), 0.8, 0.25};
}

MarbleKind GreenMarble() {
  return {SrgbCode(0x1f5a4a), SrgbCode(0x0f3a31), SrgbCode(0xb9d6c4), 0.8, 0.14};
}

SurfacePoint MarbleAt(const MarbleKind& kind, double u, double v, uint32_t seed) {
  // Veins are cracks that later folds of the rock have bent: lines of noise at places that noise moved.
  const double du = FractalNoise(u, v, 3, 3, 4, seed), dv = FractalNoise(u, v, 3, 3, 4, seed + 10);
  const double x = u + 0.09 * du, y = v + 0.09 * dv;
  const double broad = FractalNoise(x, y, 2, 2, 5, seed + 20);
  const double fine = FractalNoise(x, y, 5, 5, 4, seed + 30);
  const double clouds = FractalNoise(x, y, 3, 3, 5, seed + 40);
  const double presence = SmoothStep(-0.5, 0.5, FractalNoise(u, v, 3, 3, 2, seed + 50));
  const double vein =
      std::max({0.85 * Ridge(broad, 0.11), 0.45 * presence * Ridge(fine, 0.07), 0.3 * Ridge(broad, 0.3)});

  SurfacePoint point;
  point.color = Blend(kind.stone, kind.clouds, 0.35 + 0.6 * clouds);
  point.color = Blend(point.color, kind.veins, kind.veining * vein * (0.45 + 0.55 * presence));
  point.roughness = kind.roughness + 0.08 * vein + 0.03 * clouds;
  return point;
}

SurfaceMap Marble(int size, const MarbleKind& kind, uint32_t seed) {
  return SurfaceMap(size, [&](double u, double v) { return MarbleAt(kind, u, v, seed); });
}

SurfaceMap MarbleChecker(int size, const MarbleKind& first, const MarbleKind& second, int squares,
                         uint32_t seed) {
  SL_CHECK(squares > 0 && squares % 2 == 0);
  return SurfaceMap(size, [&](double u, double v) {
    const int column = int(std::floor(u * squares)), row = int(std::floor(v * squares));
    const double x = u * squares - column, y = v * squares - row;
    SurfacePoint point =
        (column + row) % 2 == 0 ? MarbleAt(first, u, v, seed) : MarbleAt(second, u, v, seed + 100);
    const double to_edge = std::min({x, 1 - x, y, 1 - y});
    const double groove = 1 - SmoothStep(0.008, 0.022, to_edge);
    point.color = Blend(point.color, V3f(0.12f), 0.8 * groove);
    point.roughness += 0.5 * groove;
    point.height = -0.004 / squares * groove;
    return point;
  });
}

}  // namespace shutterline::scenes
