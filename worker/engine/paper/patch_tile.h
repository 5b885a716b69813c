#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "worker/engine/paper/cell_resolver.h"
#include "worker/engine/paper/line_patches.h"
#include "worker/engine/visibility/pair_weights.h"

namespace shutterline::engine::paper {

/// Resolves a tile's lines one by one with depth patches and adds what they see to the pixels' weights.
///
/// Areas become integers as they leave a cell: the running sum of its fragments' areas is rounded, and each
/// fragment weighs the difference of two such sums. So the weights of a cell add up to the rounded sum of
/// its areas, and where polygons leave less than kCellSliver of it, to all of the cell, exactly. Cells
/// that see nothing that moves take the integer spans of what stands still as they are.
class PatchTile {
 public:
  /// A line's weight for one pixel; the same as that of instants by motion, see TimeSamples.
  static constexpr uint64_t kShutterWeight = uint64_t{1} << 22;

  PatchTile(const LinePattern& pattern, const TileTriangles& tile, const Options& options,
            PairWeights& weights, RenderStats& stats);

  /// Resolves all lines of the tile.
  void Resolve();

 private:
  void ResolveLine(const TileLine& line);
  void AddStillSpan(const VisibleSpan& span, int32_t begin, int32_t end, uint64_t weight, double t);
  void AddStillLine();
  void AddStillCell(int step, uint64_t weight, double t);
  void ResolveCell(int step, int row);
  bool AllStill() const;
  void AddFragment(int step, const CellBounds& cell, const VisibleFragment& fragment, uint64_t weight);
  int64_t PixelOf(int step) const;
  uint64_t RowWeight(int row) const;

  const LinePattern& pattern_;
  const TileTriangles& tile_;
  PairWeights& weights_;
  RenderStats& stats_;
  const TileLine* tile_line_ = nullptr;
  LinePatches line_;
  CellResolver cell_resolver_;
  std::vector<uint32_t> candidates_;
  std::vector<uint32_t> cell_pieces_;
};

}  // namespace shutterline::engine::paper
