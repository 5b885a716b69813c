#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "worker/engine/paper/depth_sort.h"
#include "worker/engine/paper/hidden_surface.h"
#include "worker/engine/paper/patch_piece.h"

namespace shutterline::engine::paper {

/// The lt-cell [l0, l0 + 1] × [t0, t1].
struct CellBounds {
  double l0 = 0, t0 = 0, t1 = 1;
};

/// Resolves one cell: patch pieces in, visible fragments out [gribel2011, sections 5.2 and 5.3].
///
/// Pieces are cut to the cell, get a plane each, are ordered by depth and integrated. A cell with very many
/// pieces is first cut in halves, again and again: a BSP tree over a million small triangles that hide one
/// another nowhere would be a list, while each half sees about half of them. **Departs** from the paper,
/// which bounds a cell's pieces by nothing.
///
/// Keeps its memory between cells; one object per thread.
class CellResolver {
 public:
  explicit CellResolver(const Options& options) : options_(options) {}

  /// Replaces fragments() by what is visible of `pieces` (pointers into `all`), whose order does not matter
  /// but for rounding.
  void Resolve(const CellBounds& cell, std::span<const uint32_t> pieces, std::span<const PatchPiece> all);

  const std::vector<VisibleFragment>& fragments() const { return fragments_; }

 private:
  /// Cells with more pieces than this are cut. Trees of this size are still faster than cutting.
  static constexpr size_t kMostInTree = 96;

  struct Rectangle {
    double u0 = 0, v0 = 0, u1 = 1, v1 = 1;
    double Area() const { return (u1 - u0) * (v1 - v0); }
  };

  void AddPiece(const CellBounds& cell, const PatchPiece& piece);
  void AddFitted(const CellBounds& cell, const PatchPiece& piece, const Polygon& polygon, int halvings);
  void BoundDepth(CellPolygon& polygon) const;
  void ResolveRegion(size_t first, const Rectangle& region, int level);
  void CullHidden(size_t first, const Rectangle& region);
  bool ResolveHalves(size_t first, const Rectangle& region, int level);
  void ResolveByTree(size_t first, const Rectangle& region);

  Options options_;
  PolygonArena arena_;
  std::vector<double> depths_;
  std::vector<CellPolygon> polygons_;  // A stack: each region's are its last.
  DepthSort depth_sort_;
  HiddenSurface hidden_surface_;
  std::vector<VisibleFragment> fragments_;
};

}  // namespace shutterline::engine::paper
