#include "tests/scenes/noise.h"

#include <algorithm>
#include <cmath>

namespace shutterline::scenes {
namespace {

uint64_t Mix(int x, int y, uint32_t seed) {
  // A point and a seed as one number, then the finalizer of SplitMix64, as in random.h.
  uint64_t z = (uint64_t(uint32_t(x)) << 32 | uint32_t(y)) + (uint64_t(seed) + 1) * 0x9e3779b97f4a7c15;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
  z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
  return z ^ (z >> 31);
}

int Wrap(int i, int period) {
  const int rest = i % period;
  return rest < 0 ? rest + period : rest;
}

double Fade(double t) {
  return t * t * t * (t * (t * 6 - 15) + 10);
}

/// The slope that lattice point (x, y) has, at (dx, dy) from it.
double Ramp(int x, int y, uint32_t seed, double dx, double dy) {
  const uint64_t bits = Mix(x, y, seed);
  const double gx = double(bits & 0xffff) / 32768 - 1, gy = double(bits >> 16 & 0xffff) / 32768 - 1;
  return gx * dx + gy * dy;
}

}  // namespace

double HashOf(int x, int y, uint32_t seed) {
  return double(Mix(x, y, seed) >> 11) * 0x1p-53;
}

double SmoothStep(double from, double to, double x) {
  const double t = std::clamp((x - from) / (to - from), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

double GradientNoise(double x, double y, int period_x, int period_y, uint32_t seed) {
  const double left = std::floor(x), top = std::floor(y);
  const double dx = x - left, dy = y - top;
  const int x0 = Wrap(int(left), period_x), x1 = Wrap(int(left) + 1, period_x);
  const int y0 = Wrap(int(top), period_y), y1 = Wrap(int(top) + 1, period_y);
  const double s = Fade(dx), t = Fade(dy);
  const double above = Ramp(x0, y0, seed, dx, dy) * (1 - s) + Ramp(x1, y0, seed, dx - 1, dy) * s;
  const double below = Ramp(x0, y1, seed, dx, dy - 1) * (1 - s) + Ramp(x1, y1, seed, dx - 1, dy - 1) * s;
  return 1.6 * (above * (1 - t) + below * t);
}

double FractalNoise(double u, double v, int cells_x, int cells_y, int octaves, uint32_t seed) {
  double sum = 0, height = 1;
  for (int octave = 0; octave < octaves; ++octave) {
    // Shifted, so that the octaves' lattices, on which noise is zero and steep, do not fall on one another.
    const double x = u * cells_x + HashOf(octave, 0, seed), y = v * cells_y + HashOf(octave, 1, seed);
    sum += height * GradientNoise(x, y, cells_x, cells_y, seed + uint32_t(octave));
    height *= 0.5;
    cells_x *= 2;
    cells_y *= 2;
  }
  return sum;
}

Cell CellAt(double u, double v, int cells_x, int cells_y, uint32_t seed) {
  const double x = u * cells_x, y = v * cells_y;
  const int column = int(std::floor(x)), row = int(std::floor(y));
  double nearest2 = 1e9, second2 = 1e9;
  Cell cell;
  for (int j = row - 1; j <= row + 1; ++j) {
    for (int i = column - 1; i <= column + 1; ++i) {
      const int wrapped_i = Wrap(i, cells_x), wrapped_j = Wrap(j, cells_y);
      // Off the cells' middles by at most 0.4, so that no nearest point lies beyond the neighbours.
      const double px = i + 0.1 + 0.8 * HashOf(wrapped_i, wrapped_j, seed);
      const double py = j + 0.1 + 0.8 * HashOf(wrapped_i, wrapped_j, seed + 1);
      const double away2 = (px - x) * (px - x) + (py - y) * (py - y);
      if (away2 < nearest2) {
        second2 = nearest2;
        nearest2 = away2;
        cell.number = HashOf(wrapped_i, wrapped_j, seed + 2);
      } else {
        second2 = std::min(second2, away2);
      }
    }
  }
  cell.nearest = std::sqrt(nearest2);
  cell.second = std::sqrt(second2);
  return cell;
}

}  // namespace shutterline::scenes
