#pragma once

#include <cstdint>

/// Noise for pictures that repeat without a seam. Sums, products, floors and square roots alone, so that
/// every machine computes the same bits.
namespace shutterline::scenes {

/// Uniform in [0, 1), by a point of a lattice.
double HashOf(int x, int y, uint32_t seed);

/// 0 below `from`, 1 above `to`, smooth between; `from` < `to`.
double SmoothStep(double from, double to, double x);

/// Gradient noise ([perlin2002]; gradients by hash) over a lattice of unit cells that repeats after
/// `period_x` and `period_y` of them. About -1 to 1, 0 on the lattice.
double GradientNoise(double x, double y, int period_x, int period_y, uint32_t seed);

/// Octaves of GradientNoise over the unit square, which it tiles: `cells_x` × `cells_y` cells in the
/// first, twice as many and half the height in each further one. About -1 to 1.
double FractalNoise(double u, double v, int cells_x, int cells_y, int octaves, uint32_t seed);

/// A point a cell, scattered ([worley1996]): the distances, in cells, to the two nearest, and a uniform
/// number in [0, 1) that is the nearest's own.
struct Cell {
  double nearest = 0, second = 0, number = 0;
};
/// Over the unit square, which it tiles, in `cells_x` × `cells_y` cells.
Cell CellAt(double u, double v, int cells_x, int cells_y, uint32_t seed);

}  // namespace shutterline::scenes
