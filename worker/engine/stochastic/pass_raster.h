#pragma once

#include <cstdint>
#include <vector>

#include <hwy/aligned_allocator.h>

#include "worker/engine/stochastic/cell.h"
#include "worker/engine/stochastic/sample_keys.h"

namespace shutterline::engine {

/// The samples of a pass over a cell and what they see, by SampleIndex. One for each thread.
struct PassBuffers {
  hwy::AlignedFreeUniquePtr<float[]> x, y, tau;  ///< Where samples are: units of the cell, tau.
  hwy::AlignedFreeUniquePtr<float[]> depth;      ///< Nearest so far.
  /// 1 + the index in CellTriangles of what is seen; 0 is the background.
  hwy::AlignedFreeUniquePtr<uint32_t[]> seen;
  /// Of samples whose triangle needs a position: its barycentric coordinates of vertices 1 and 2.
  hwy::AlignedFreeUniquePtr<float[]> b1, b2;
  /// By pixel in rows, one array for each key.
  std::vector<uint32_t> key_a, key_b, key_c, key_t;
  /// Farthest of the nearest depths of a block's samples.
  std::vector<float> farthest;
  /// Triangles that a pass may see, and the blocks that they may touch: first and last column and row, a
  /// byte each from the lowest.
  std::vector<uint32_t> active, blocks;

  PassBuffers();
};

/// A part of the shutter over a part of a cell.
struct Pass {
  PassShape shape;
  int spp = 1;
  int first_stratum = 0;  ///< A multiple of shape.strata.
  /// Pixels of the cell that are wanted: [x0, x1) × [y0, y1).
  int x0 = 0, y0 = 0, x1 = kCellSize, y1 = kCellSize;
};

struct PassCounts {
  int64_t visited = 0;  ///< Triangles that met the pass.
  int64_t tested = 0;   ///< Vectors tested against a triangle.
  int64_t hit = 0;      ///< Of these, the vectors of which the triangle covered a sample.
};

/// Makes the samples of a pass (whose keys lie in `buffers`) and finds what each sees. Samples of strata
/// from `spp` on see the background.
///
/// Compiled for several instruction sets, the best of which is taken at run time. Each sample is a lane of
/// its own, multiplications and additions are fused on every one, and results never depend on the width
/// of a vector: pictures are equal to the last bit. Bounds, which may differ, decide only what is tested.
PassCounts RasterizePass(const CellTriangles& cell, const Pass& pass, PassBuffers& buffers);

}  // namespace shutterline::engine
