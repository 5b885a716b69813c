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

/// The homogeneous line coordinates of a vertex: row · w, position · w (pixels), depth · w, w.
inline constexpr int kLineCoordinates = 4;

/// Vertices of the triangles that a group of lines may meet in a stratum of the shutter, as polynomials in
/// time: structure of arrays, coefficient k of coordinate c at power[k][c][vertex]. The first `linear`
/// vertices move on straight lines (or not at all) and have two coefficients in the shutter time; the others
/// have four, in the time of their piece, t · time_scale + time_offset.
struct MovingVertices {
  size_t linear = 0, count = 0;
  std::array<std::array<std::vector<double>, kLineCoordinates>, 4> power;
  std::vector<double> time_scale, time_offset;  ///< Of the vertices from `linear` on, by vertex − linear.
};

/// The vertices at one instant. Where a vertex is beyond the near or the far plane, `row` is NaN.
struct PlacedVertices {
  std::vector<double> row;       ///< Pixels: lane i lies at row i.
  std::vector<double> position;  ///< Along the lines, subpixels.
  std::vector<double> depth;

  size_t size() const { return row.size(); }
  void Resize(size_t n) {
    row.resize(n);
    position.resize(n);
    depth.resize(n);
  }
};

}  // namespace shutterline::engine
