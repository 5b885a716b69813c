#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "worker/engine/slice/moving_vertices.h"

namespace shutterline::engine {

/// What the set-up must know of a triangle that a group of lines may meet.
struct GroupTriangle {
  std::array<int32_t, 3> vertices{};
  uint32_t index = 0;  ///< In the tile's mesh.
  double t_in = 2, t_out = -1;
  /// Not drawn where facing · signed area < 0 in (row, position); 0: both sides are.
  double facing = 0;
};

/// The same for many, as a structure of arrays.
struct GroupTriangles {
  size_t count = 0;
  std::array<std::vector<int32_t>, 3> vertex;
  std::vector<uint32_t> index;
  std::vector<double> t_in, t_out, facing;

  /// Makes room for n triangles and as many as fill up the last vector.
  void Reserve(size_t n) {
    n = Padded(n);
    if (index.size() >= n) return;
    for (auto& v : vertex) v.resize(n);
    index.resize(n);
    for (auto* v : {&t_in, &t_out, &facing}) v->resize(n);
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
    facing[i] = triangle.facing;
  }
};

/// Triangles at one instant, ready to be cut by lines: corners a, b, c in ascending row, and for each edge
/// the reciprocal of its height. `ab` etc. are differences of the later corner and the earlier.
struct PlacedTriangles {
  std::vector<double> row_a, row_b;
  std::vector<double> inverse_ac, inverse_ab, inverse_bc;
  std::vector<double> position_a, position_ac, position_ab, position_b, position_bc;
  std::vector<float> depth_a, depth_ac, depth_ab, depth_b, depth_bc;
  std::vector<float> nearest;  ///< Depth.
  std::vector<int32_t> first_lane, last_lane;
  std::vector<int32_t> least, most;  ///< Bounds along the lines, subpixels, within the lines' length.
  /// Those that meet a lane within the lines' length, in ascending order; the others are not set up.
  std::vector<uint32_t> met;
  /// Those with a corner beyond the near or the far plane.
  std::vector<uint32_t> clipped;

  void Resize(size_t n) {
    for (auto* v : {&row_a, &row_b, &inverse_ac, &inverse_ab, &inverse_bc, &position_a, &position_ac,
                    &position_ab, &position_b, &position_bc}) {
      if (v->size() < n) v->resize(n);
    }
    for (auto* v : {&depth_a, &depth_ac, &depth_ab, &depth_b, &depth_bc, &nearest}) {
      if (v->size() < n) v->resize(n);
    }
    for (auto* v : {&first_lane, &last_lane, &least, &most}) {
      if (v->size() < n) v->resize(n);
    }
  }
};

}  // namespace shutterline::engine
