#include "tests/scenes/wood.h"

#include <algorithm>
#include <cmath>

#include "tests/scenes/noise.h"

namespace shutterline::scenes {

WoodKind Maple() {
  return {SrgbCode(0xe9cfa1), SrgbCode(0xc9986a), SrgbCode(0xb07f4f), 9, 0.8, 0.42};
}

WoodKind Walnut() {
  return {SrgbCode(0x80522f), SrgbCode(0x482815), SrgbCode(0x2b160b), 11, 1.0, 0.4};
}

WoodKind Mahogany() {
  return {SrgbCode(0x8a4426), SrgbCode(0x572112), SrgbCode(0x331009), 8, 0.8, 0.35};
}

WoodKind Rosewood() {
  return {SrgbCode(0x85502f), SrgbCode(0x1f0e09), SrgbCode(0x170a06), 12, 1.25, 0.32};
}

SurfaceMap Wood(int size, const WoodKind& kind, uint32_t seed) {
  return SurfaceMap(size, [&](double u, double v) {
    // Cut rings: lines along the grain that bend where the trunk did, in arches where the saw grazed one.
    const double bend = FractalNoise(u, v, 2, 1, 3, seed);
    const double waver = FractalNoise(u, v, 12, 2, 2, seed + 10);
    const double place = kind.rings * u + 2.2 * bend + 0.1 * waver;
    const int year = int(std::floor(place));
    const double in_year = place - year;
    // Wood darkens through the year and ends at a sharp line; no two years are alike.
    const int repeated = (year % kind.rings + kind.rings) % kind.rings;
    const double strength = 0.55 + 0.45 * HashOf(repeated, 0, seed + 20);
    const double late = strength * in_year * in_year * SmoothStep(1.0, 0.9, in_year);

    const double fibre = FractalNoise(u, v, 96, 4, 2, seed + 30);
    const double patches = FractalNoise(u, v, 3, 2, 2, seed + 40);
    const double pore_field = GradientNoise(u * 128, v * 12, 128, 12, seed + 50);
    const double pores = SmoothStep(0.42, 0.7, pore_field) * (0.4 + 0.6 * (1 - in_year));

    SurfacePoint point;
    point.color = Blend(kind.early, kind.late, kind.contrast * late + 0.14 + 0.16 * fibre + 0.12 * patches);
    point.color = Blend(point.color, kind.pores, 0.7 * pores);
    point.roughness = kind.roughness - 0.08 * late + 0.05 * fibre + 0.2 * pores;
    point.height = 0.0004 * fibre - 0.0012 * pores + 0.0006 * late;
    return point;
  });
}

}  // namespace shutterline::scenes
