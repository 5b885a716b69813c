#pragma once

#include <absl/container/flat_hash_map.h>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/job/tile.h"
#include "worker/engine/render/stats.h"
#include "worker/engine/shading/shade.h"
#include "worker/engine/stochastic/cell.h"
#include "worker/engine/stochastic/pass_raster.h"

namespace shutterline::engine {

/// Turns what a cell's samples see into pixels under a box filter.
///
/// A triangle whose shading is constant is shaded once a cell, and its colour is added sample by sample.
/// Others are shaded once for each pixel that sees them (and each shading bin of the shutter), at the mean
/// position of the pixel's samples on them. Sums run through the strata in order: they do not depend on
/// how passes are cut.
class CellFilm {
 public:
  /// Empties, for a part of a cell and its triangles, which must live on, as must the shader.
  void Reset(const Shader& shader, const CellTriangles& cell);

  void AddPass(const Pass& pass, const PassBuffers& buffers);

  /// Writes the pixels of `pass`'s part of the cell, whose corner is (x, y), into `rgba`, the pixels of
  /// `rect`. Adds the shaded pairs to `stats`.
  void Write(const Pass& pass, int x, int y, const TileRect& rect, std::span<float> rgba, RenderStats& stats);

 private:
  /// Red, green, blue and alpha, added as one vector: a language extension that GCC and Clang share.
  using Rgba [[gnu::vector_size(16)]] = float;
  /// What one pixel sees of one triangle in one shading bin.
  struct Pair {
    uint32_t id = 0;        ///< In the frame.
    uint32_t triangle = 0;  ///< Of the cell: a piece of its motion.
    uint32_t bin = 0;
    uint32_t count = 0;
    uint32_t next = 0;  ///< Of the pixel; 0: none.
    double b1 = 0, b2 = 0;
  };

  void AddConstant(const Pass& pass, const PassBuffers& buffers);
  template <int kPixels>
  void AddBlock(const uint32_t* seen, int samples, Rgba* sums);
  void AddVarying(const Pass& pass, const PassBuffers& buffers);
  const Rgba& ColorOf(uint32_t seen);
  Pair& PairOf(int pixel, uint32_t id, uint32_t triangle, uint32_t bin);
  V3f ShadePair(const Pair& pair) const;

  const Shader* shader_ = nullptr;
  const CellTriangles* cell_ = nullptr;
  bool varying_ = false;  ///< Some triangle needs a position.
  /// By what is seen: 0 is the background. Alpha is negative where it has not been shaded yet.
  std::vector<Rgba> colors_;
  // By pixel, in the order of the shape's blocks: sums of the present group of strata, and of all before.
  std::vector<Rgba> group_;
  std::vector<std::array<double, 4>> total_;
  std::vector<Pair> pairs_;                         ///< The first is unused.
  std::vector<uint32_t> first_pair_, latest_pair_;  ///< By pixel.
  std::vector<uint32_t> pair_count_;
  absl::flat_hash_map<std::array<uint32_t, 3>, uint32_t> index_;  ///< Of pixels with many pairs.
};

}  // namespace shutterline::engine
