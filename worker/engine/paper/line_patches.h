#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "worker/engine/paper/cell_grid.h"
#include "worker/engine/paper/depth_patch.h"
#include "worker/engine/paper/patch_piece.h"
#include "worker/engine/render/stats.h"
#include "worker/engine/visibility/front_to_back.h"

namespace shutterline::engine::paper {

/// What the patch engine makes of a point of a line sample at an instant.
struct PatchSight {
  uint32_t triangle = 0;  ///< Index into FrameScene::triangles.
  double depth = 0;       ///< z/w, by the patch's plane: larger is nearer.
};

/// One line sample's visible candidates: what stands still, resolved once along the line, and the patch
/// pieces of what moves, binned into the line's cells.
///
/// Keeps its memory between lines; one object per thread.
class LinePatches {
 public:
  LinePatches(const LinePattern& pattern, const TileTriangles& tile, const Options& options,
              RenderStats& stats)
      : pattern_(pattern), tile_(tile), options_(options), stats_(stats) {}

  /// Gathers a line's candidates among `candidates` (indices into the tile's triangles, nearest first).
  void Gather(const TileLine& line, std::span<const uint32_t> candidates);

  const SegmentLine& line() const { return line_; }
  /// The envelope of what stands still. Where nothing moves it is the answer.
  const FrontToBack& still() const { return still_; }
  bool moves() const { return moves_; }
  /// The cells; empty unless moves(). What stands still is binned too: as one piece a visible span.
  const CellGrid& cells() const { return cells_; }
  std::span<const PatchPiece> pieces() const { return pieces_; }

  /// What the patches show at (l, t): l in pixels from the tile's corner, t in shutter time. For measuring
  /// how good they are; looks at all pieces.
  std::optional<PatchSight> SeeAt(double l, double t) const;

 private:
  void ResolveStill(std::span<const uint32_t> candidates);
  void BinStill();
  void BinMoving(uint32_t index);
  bool Touches(const TileTriangle& triangle) const {
    return triangle.first_line[size_t(family_)] <= number_ && number_ <= triangle.last_line[size_t(family_)];
  }

  const LinePattern& pattern_;
  const TileTriangles& tile_;
  Options options_;
  RenderStats& stats_;

  int family_ = 0;
  int64_t number_ = 0;
  int first_step_ = 0, end_step_ = 0;
  SegmentLine line_;
  FrontToBack still_;
  DepthPatch patch_;
  CellGrid cells_;
  std::vector<PatchPiece> pieces_;
  bool moves_ = false;
};

}  // namespace shutterline::engine::paper
