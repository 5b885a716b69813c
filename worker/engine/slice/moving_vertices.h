#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace shutterline::engine {

/// Arrays of the kernels are padded to a multiple of this many elements, so that they read and write whole
/// vectors.
inline constexpr size_t kPad = 16;
inline constexpr size_t Padded(size_t n) {
  return (n + kPad - 1) / kPad * kPad;
}

/// The homogeneous raster coordinates of a vertex, relative to the tile: X, Y (pixels · w), Z (depth · w), W.
inline constexpr int kRasterCoordinates = 4;

/// Vertices of the triangles that a tile may see in a part of the shutter, as polynomials in time: structure
/// of arrays, coefficient k of coordinate c at power[k][c][vertex]. The first `linear` vertices move on
/// straight lines (or not at all) and have two coefficients in the shutter time; the others, from
/// Padded(linear) on, have four, in the time of their piece, t · time_scale + time_offset.
struct MovingVertices {
  size_t linear = 0, curved = 0;
  std::array<std::array<std::vector<double>, kRasterCoordinates>, 4> power;
  std::vector<double> time_scale, time_offset;  ///< Of the curved ones, by number of those.

  size_t first_curved() const { return Padded(linear); }
  size_t size() const { return first_curved() + Padded(curved); }
};

/// The vertices at one instant in the coordinates of a class of lines. Where a vertex is beyond the near or
/// the far plane, `row` is NaN.
struct PlacedVertices {
  std::vector<double> row;       ///< Pixels: line i of the class lies at row i.
  std::vector<double> position;  ///< Along the lines, subpixels.
  std::vector<double> depth;
  std::vector<double> inverse_w;

  size_t size() const { return row.size(); }
  /// Keeps what is there.
  void Grow(size_t n) {
    if (row.size() >= n) return;
    row.resize(n);
    position.resize(n);
    depth.resize(n);
    inverse_w.resize(n);
  }
};

}  // namespace shutterline::engine
