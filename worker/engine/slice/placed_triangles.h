#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "worker/engine/slice/moving_vertices.h"

namespace shutterline::engine {

/// What the set-up must know of a triangle that a tile may see.
struct GroupTriangle {
  std::array<int32_t, 3> vertices{};
  uint32_t index = 0;  ///< In the tile's mesh.
  double t_in = 2, t_out = -1;
  /// 1 where it is not drawn seen from the back; 0: both sides are.
  double one_sided = 0;
};

/// The same for many, as a structure of arrays.
struct GroupTriangles {
  size_t count = 0;
  std::array<std::vector<int32_t>, 3> vertex;
  std::vector<uint32_t> index;
  std::vector<double> t_in, t_out, one_sided;

  /// Makes room for n triangles and as many as fill up the last vector.
  void Reserve(size_t n) {
    n = Padded(n);
    if (index.size() >= n) return;
    for (auto& v : vertex) v.resize(n);
    index.resize(n);
    for (auto* v : {&t_in, &t_out, &one_sided}) v->resize(n);
  }
  /// Room must have been made.
  void Add(const GroupTriangle& triangle) { Set(count++, triangle); }
  /// Fills up the last vector with triangles that are never met.
  void Pad() {
    for (size_t i = count; i < Padded(count); ++i) Set(i, {});
  }

 private:
  void Set(size_t i, const GroupTriangle& triangle) {
    for (size_t k = 0; k < 3; ++k) vertex[k][i] = triangle.vertices[k];
    index[i] = triangle.index;
    t_in[i] = triangle.t_in;
    t_out[i] = triangle.t_out;
    one_sided[i] = triangle.one_sided;
  }
};

/// A block of triangles at one instant, ready to be cut by a class's lines: corners a, b, c in ascending row,
/// and for each edge the reciprocal of its height. `ab` etc. are differences of the later corner and the
/// earlier. Small enough to stay in the nearest cache.
struct PlacedTriangles {
  /// Some vectors' worth, and few enough that little is placed in vain.
  static constexpr size_t kMost = 128;
  template <typename T>
  using Array = std::array<T, kMost>;

  alignas(64) Array<double> row_a, row_b;
  alignas(64) Array<double> inverse_ac, inverse_ab, inverse_bc;
  alignas(64) Array<double> position_a, position_ac, position_ab, position_b, position_bc;
  alignas(64) Array<float> depth_a, depth_ac, depth_ab, depth_b, depth_bc;
  alignas(64) Array<float> nearest;  ///< Depth.
  alignas(64) Array<int32_t> first_row, last_row;
  alignas(64) Array<int32_t> least, most;  ///< Bounds along the lines, subpixels, within the lines' length.
  alignas(64) Array<uint32_t> index;       ///< In the tile's mesh.
  /// Those that meet a line within its length, in ascending order; the others are not set up.
  Array<uint8_t> met;
  size_t met_count = 0;
  /// Those with a corner beyond the near or the far plane.
  Array<uint8_t> clipped;
  size_t clipped_count = 0;
};
static_assert(PlacedTriangles::kMost % kPad == 0 && PlacedTriangles::kMost <= 256);

}  // namespace shutterline::engine
