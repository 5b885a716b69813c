#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "worker/engine/shading/texel_levels.h"

namespace shutterline::engine {

/// Points on projected triangles, gathered until there are enough for vectors to find the texels around them.
/// Small enough to stay in the nearest cache.
struct TexelBatch {
  static constexpr size_t kMost = 128;
  template <typename T>
  using Array = std::array<T, kMost>;

  /// Adds a point: its barycentric coordinates b1 and b2 and their sum with b0, all over w. There must be
  /// room.
  void Add(double b1_w, double b2_w, double one_w, const TexelLevelsOfTriangle& levels) {
    const size_t n = count++;
    b1[n] = b1_w;
    b2[n] = b2_w;
    one_over_w[n] = one_w;
    if (levels.is_uniform()) {
      columns[n] = levels.columns();
      rows[n] = levels.rows();
      return;
    }
    const size_t k = uneven_count++;
    uneven[k] = uint32_t(n);
    uneven_over_w[k] = one_w;
    const TexelLevelsOfTriangle::Rise rise = levels.RiseAt(b1_w, b2_w, one_w);
    w[k] = rise.w;
    squared1[k] = rise.squared1;
    squared2[k] = rise.squared2;
  }
  void Clear() { count = uneven_count = 0; }

  size_t count = 0;
  alignas(64) Array<double> b1, b2;  ///< Over w; FindTexels makes them what they are on the triangle.
  alignas(64) Array<double> one_over_w;
  /// Numbers of columns and rows of the level; FindTexels fills in where triangles have several levels. No
  /// columns: the point has no texel.
  alignas(64) Array<double> columns, rows;
  alignas(64) Array<int32_t> i, j;  ///< The texel's column and row, by FindTexels.

  // Points of triangles with several levels.
  size_t uneven_count = 0;
  Array<uint32_t> uneven;
  alignas(64) Array<double> uneven_over_w, w, squared1, squared2;
};

/// Finds the texels of all points: those of TexelLevelsOfTriangle and TexelAt, but for roundings where two
/// meet.
void FindTexels(TexelBatch& batch);

}  // namespace shutterline::engine
