#include "tests/scenes/stone.h"

#include <algorithm>
#include <cmath>

#include "common/base/check.h"
#include "tests/scenes/noise.h"

namespace shutterline::scenes {
namespace {

/// Distance from the border of a rectangle of `width` × `height` with rounded corners; from outside, 0.
double InsideOf(double x, double y, double width, double height, double corner) {
  const double dx = std::min(x, width - x), dy = std::min(y, height - y);
  if (dx < corner && dy < corner) {
    const double ex = corner - dx, ey = corner - dy;
    return std::max(0.0, corner - std::sqrt(ex * ex + ey * ey));
  }
  return std::max(0.0, std::min(dx, dy));
}

/// Joints where `inside` is small: as wide as `joint`, with an edge worn over `wear`.
void CutJoint(SurfacePoint& point, const V3f& joints, double inside, double joint, double wear, double deep) {
  const double stone = SmoothStep(joint * 0.7, joint * 1.3, inside);
  const double worn = SmoothStep(joint, joint + wear, inside);
  point.color = Blend(joints, Blend(point.color * 0.82f, point.color, worn), stone);
  point.roughness = point.roughness * stone + 0.95 * (1 - stone);
  point.height = point.height * stone + deep * (0.6 * stone + 0.4 * worn - 1);
}

}  // namespace

StoneKind Travertine() {
  return {SrgbCode(0xc2ae8d), SrgbCode(0xe9dfc9), SrgbCode(0x7d6f5b), 0.35};
}

StoneKind RedLimestone() {
  return {SrgbCode(0x6e3d2c), SrgbCode(0xa5684c), SrgbCode(0x5c5044), 0.35};
}

StoneKind Sandstone() {
  return {SrgbCode(0xbb9c70), SrgbCode(0xe2cda4), SrgbCode(0xa39172), 0.85};
}

StoneKind Slate() {
  return {SrgbCode(0x3c474c), SrgbCode(0x64737a), SrgbCode(0x2a3236), 0.55};
}

StoneKind Terracotta() {
  return {SrgbCode(0x9c4a2b), SrgbCode(0xc9764c), SrgbCode(0x6b3522), 0.75};
}

SurfaceMap FloorTiles(int size, const StoneKind& kind, int slabs, uint32_t seed) {
  return SurfaceMap(size, [&](double u, double v) {
    const int column = int(std::floor(u * slabs)), row = int(std::floor(v * slabs));
    const int number = row * slabs + column;
    double x = u * slabs - column, y = v * slabs - row;
    const double ragged = 0.006 * FractalNoise(u, v, 12 * slabs, 12 * slabs, 2, seed + 1);
    const double inside = InsideOf(x, y, 1, 1, 0.03) + ragged;
    if (number % 2 == 1) std::swap(x, y);  // Layers run along every second slab, across the others.
    const uint32_t own = seed + 100 * uint32_t(number);
    // Layers of the rock, and holes along them; a slab's own noise need not tile.
    const double layers = FractalNoise(x * 0.25, y, 4, 6, 5, own + 10);
    const double grain = FractalNoise(x, y, 24, 40, 3, own + 20);
    const double holes = SmoothStep(0.5, 0.72, GradientNoise(x * 14, y * 40, 14, 40, own + 30));
    const double tone = HashOf(number, 0, seed + 2) - 0.5;

    SurfacePoint point;
    point.color = Blend(kind.dark, kind.light, 0.5 + 0.55 * layers + 0.12 * grain + 0.5 * tone);
    point.color = Blend(point.color, kind.joints, 0.75 * holes);
    point.roughness = kind.roughness + 0.12 * layers + 0.1 * grain + 0.4 * holes;
    point.height = (0.0008 * grain - 0.005 * holes) / slabs;
    CutJoint(point, kind.joints, inside, 0.009, 0.025, 0.01 / slabs);
    return point;
  });
}

SurfaceMap Masonry(int size, const StoneKind& kind, int courses, uint32_t seed) {
  SL_CHECK(courses > 0 && courses % 2 == 0);
  const int blocks = courses / 2;  // In a course: a block is twice as long as high.
  return SurfaceMap(size, [&](double u, double v) {
    const int course = int(std::floor(v * courses));
    const double along = u * blocks + (course % 2 == 0 ? 0.0 : 0.5);
    const int number = int(std::floor(along)) % blocks;
    const double x = 2 * (along - std::floor(along)), y = v * courses - course;  // In heights of a course.
    const double ragged = 0.02 * FractalNoise(u, v, 8 * courses, 8 * courses, 3, seed + 1);
    const double inside = InsideOf(x, y, 2, 1, 0.08) + ragged;
    const double beds = FractalNoise(u, v, 3, 24, 4, seed + 10);
    const double grain = FractalNoise(u, v, 64, 64, 3, seed + 20);
    const double patches = FractalNoise(u, v, 4, 4, 4, seed + 30);
    const double tone = HashOf(number, course, seed + 2) - 0.5;

    SurfacePoint point;
    point.color = Blend(kind.dark, kind.light, 0.5 + 0.3 * beds + 0.14 * grain + 0.25 * patches + 0.6 * tone);
    point.roughness = kind.roughness + 0.08 * grain;
    point.height = (0.012 * grain + 0.03 * patches) / courses;
    CutJoint(point, kind.joints, inside, 0.035, 0.07, 0.07 / courses);
    return point;
  });
}

SurfaceMap Rock(int size, const StoneKind& kind, uint32_t seed) {
  return SurfaceMap(size, [&](double u, double v) {
    const double x = u + 0.03 * FractalNoise(u, v, 6, 6, 3, seed);
    const double folds = FractalNoise(x, v, 4, 8, 6, seed + 10);
    const double grain = FractalNoise(u, v, 48, 48, 3, seed + 20);
    const double cracks = 1 - SmoothStep(0.0, 0.02, std::abs(FractalNoise(x, v, 3, 3, 5, seed + 30)));
    SurfacePoint point;
    point.color = Blend(kind.dark, kind.light, 0.5 + 0.5 * folds + 0.22 * grain);
    point.color = Blend(point.color, kind.joints, 0.5 * cracks);
    point.roughness = kind.roughness + 0.12 * folds + 0.1 * grain;
    point.height = 0.004 * folds + 0.0008 * grain - 0.001 * cracks;
    return point;
  });
}

SurfaceMap Plaster(int size, const V3f& color, uint32_t seed) {
  const V3f stain = color * V3f(0.66f, 0.6f, 0.5f), bright = Blend(color, V3f(1), 0.35);
  return SurfaceMap(size, [&](double u, double v) {
    const double patches = FractalNoise(u, v, 3, 3, 5, seed);
    const double runs = FractalNoise(u, v, 14, 2, 3, seed + 10);  // Of rain, down the wall.
    const double trowel = FractalNoise(u, v, 9, 14, 3, seed + 20);
    const double grain = FractalNoise(u, v, 90, 90, 2, seed + 30);
    const double bent = FractalNoise(u + 0.02 * trowel, v, 2, 2, 5, seed + 40);
    const double cracks = (1 - SmoothStep(0.004, 0.018, std::abs(bent))) * SmoothStep(0.0, 0.4, patches);
    SurfacePoint point;
    point.color = Blend(color, bright, 0.3 + 0.7 * trowel + 0.3 * grain);
    point.color = Blend(point.color, stain, 0.6 * SmoothStep(0.05, 0.9, patches + 0.4 * runs));
    point.color = Blend(point.color, stain * 0.55f, 0.7 * cracks);
    point.roughness = 0.88 + 0.06 * grain;
    point.height = 0.0022 * trowel + 0.0003 * grain - 0.0012 * cracks;
    return point;
  });
}

}  // namespace shutterline::scenes
