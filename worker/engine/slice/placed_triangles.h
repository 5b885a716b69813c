#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "worker/engine/slice/moving_vertices.h"

namespace shutterline::engine {

/// Triangles that a group of lines may meet, nearest first: indices into the vertices, and what the set-up
/// must know of each.
struct GroupTriangles {
  size_t count = 0;
  std::array<std::vector<int32_t>, 3> vertex;
  std::vector<uint32_t> index;  ///< In the tile's mesh.
  std::vector<uint32_t> id;     ///< In the frame: of two at equal depth the lower hides the other.
  std::vector<double> t_in, t_out;
  /// Drawn where facing · signed area >= 0 in (row, position); 0: both sides are.
  std::vector<double> facing;

  void Clear() {
    count = 0;
    for (auto& v : vertex) v.clear();
    index.clear();
    id.clear();
    t_in.clear();
    t_out.clear();
    facing.clear();
  }
  void Add(const std::array<int32_t, 3>& vertices, uint32_t tile_index, uint32_t frame_id, double from,
           double to, double drawn_facing) {
    for (int i = 0; i < 3; ++i) vertex[i].push_back(vertices[i]);
    index.push_back(tile_index);
    id.push_back(frame_id);
    t_in.push_back(from);
    t_out.push_back(to);
    facing.push_back(drawn_facing);
    ++count;
  }
  /// Fills up to a whole vector with triangles that are never met.
  void Pad() {
    while (id.size() % kPad != 0) {
      for (auto& v : vertex) v.push_back(0);
      index.push_back(0);
      id.push_back(0);
      t_in.push_back(2);
      t_out.push_back(-1);
      facing.push_back(0);
    }
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
  std::vector<uint8_t> met;      ///< 1: meets a lane within the lines' length. By triangle.
  std::vector<uint8_t> clipped;  ///< 1: a corner is beyond the near or the far plane.

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
    for (auto* v : {&met, &clipped}) {
      if (v->size() < n) v->resize(n);
    }
  }
};

}  // namespace shutterline::engine
