#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "worker/engine/scene/frame_scene.h"

/// What the set-up in double precision hands to the vector code in single precision.
///
/// Pixels are worked on in cells of 32 × 32 whose corners are multiples of 32 of absolute raster space, and
/// positions are relative to a cell's corner in units of its side. So whatever rectangle is asked for, the
/// same numbers are rounded in the same way.
namespace shutterline::engine {

inline constexpr int kCellSize = 32;
/// Samples that one step of the vector code tests: a block of pixels times a few strata of time.
inline constexpr int kVectorSamples = 16;
/// Sums of colour are carried in single precision over aligned groups of so many strata, then in double;
/// passes never straddle a group. Also the most strata of a pass.
inline constexpr int kMostPassStrata = 16;

/// Time within the shutter as samples have it: tau = 2 t - 1, from -1 to 1.
constexpr double TauOf(double t) {
  return 2 * t - 1;
}

/// A triangle of a cell, on one piece of its motion. Vertices are p_k(u) = (x, y, z, w), polynomials of
/// `degree` scaled by a power of two of their own (which projection takes away again), where the piece's time
/// u runs from -1 to 1: powers stay small. Edge k lies opposite to vertex k, between the two others: its
/// function e(x, y, u) = det((x, y, 1), p_i, p_j) is affine in x and y, of degree 2 * degree in u
/// [akenine2007, eq. 3], and made from its vertices in the order of their numbers: triangles that share it
/// get the same bits.
struct CellTriangle {
  uint32_t id = 0;  ///< Index into FrameScene::triangles.
  uint8_t degree = 0;
  bool partial = false;  ///< There are other pieces: it is there for u in [-1, 1] only.
  bool cull_back = false;
  bool needs_position = false;  ///< Shading varies: barycentric coordinates are wanted.
  uint8_t shading_bins_log2 = 0;
  /// u = time_scale * tau + time_offset; for degree 0 there is no u.
  float time_scale = 1, time_offset = 0;
  /// No depth of it, over the whole piece, is larger (nearer).
  float nearest_depth = 1;
  /// Sign bits that turn the edge functions towards the triangle's front: there all three are positive.
  std::array<uint32_t, 3> edge_signs{};
  /// Weights that turn edge functions into barycentric coordinates: they undo the vertices' own scales.
  std::array<float, 3> barycentric_scale{};
  /// Where its coefficients begin: for each edge and power of u a, b, c of a x + b y + c; then, for each
  /// vertex, w by powers of u; then z likewise. Degree 0 has z / det in place of both, 3 numbers.
  size_t first_coefficient = 0;
};

/// All triangles that a cell may see, nearest first.
struct CellTriangles {
  int degree = 0;          ///< The highest of any triangle.
  bool constant_z = true;  ///< z does not depend on time, as in perspective views.
  float far_depth = 0;     ///< Depths below it are clipped.
  std::vector<CellTriangle> triangles;
  std::vector<float> coefficients;

  /// Vertices once more for bounds, an array over all triangles for each of: vertex (3) × (x, y, w) × power
  /// of u (degree + 1). Arrays are `stride` long, what is behind the last triangle bounds nothing.
  std::vector<float> path;
  size_t stride = 0;
  /// By triangle: largest |x| and |y| of a control point; bounds what rounding can do to its path.
  std::vector<float> reach;
  std::vector<float> time_scale, time_offset;  ///< As in `triangles`.

  /// By triangle, rough, for choosing how to cut: width, height, and path in x and y over the shutter, in
  /// pixels.
  std::vector<std::array<float, 4>> extent;

  const float* Path(int vertex, int axis, int power) const {
    return path.data() + size_t((vertex * 3 + axis) * (degree + 1) + power) * stride;
  }
};

/// How a cell's samples are cut into vectors and passes. A vector is a block of B × B pixels, B = 1, 2 or 4,
/// times 16 / B² neighbouring strata of time; a pass is a stretch of the shutter for which triangles are
/// bounded once. It decides speed alone.
struct PassShape {
  int block_log2 = 2;  ///< log2 B
  int strata = 1;      ///< Of a pass: a power of two, at least 16 / B², at most kMostPassStrata.

  int block() const { return 1 << block_log2; }
  int blocks_per_side() const { return kCellSize >> block_log2; }
  /// Strata that a vector spans.
  int vector_strata() const { return kVectorSamples >> (2 * block_log2); }
  /// Vectors of a block in a pass.
  int vectors() const { return strata / vector_strata(); }

  friend bool operator==(const PassShape&, const PassShape&) = default;
};

/// The place of a pixel in the order of blocks.
inline size_t PixelIndex(const PassShape& shape, int x, int y) {
  const int log2 = shape.block_log2, mask = shape.block() - 1;
  const int block = (y >> log2) * shape.blocks_per_side() + (x >> log2);
  return (size_t(block) << (2 * log2)) + size_t(((y & mask) << log2) + (x & mask));
}

/// Of a pixel's samples in a pass, where stratum `s` of pixel (x, y) of the cell lies in PassBuffers.
inline size_t SampleIndex(const PassShape& shape, int x, int y, int s) {
  const int mask = shape.block() - 1;
  const int block = (y >> shape.block_log2) * shape.blocks_per_side() + (x >> shape.block_log2);
  const int vector = s / shape.vector_strata();
  const int lane = ((s & (shape.vector_strata() - 1)) << (2 * shape.block_log2)) +
                   ((y & mask) << shape.block_log2) + (x & mask);
  return size_t(block * shape.vectors() + vector) * kVectorSamples + size_t(lane);
}

}  // namespace shutterline::engine
