#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "worker/engine/slice/line_sums.h"
#include "worker/engine/slice/tile_mesh.h"
#include "worker/engine/visibility/layers.h"
#include "worker/engine/visibility/line_position.h"

namespace shutterline::engine {

/// Puts layers, surfaces that let light through, over what is visible behind them on one line at one instant:
/// front to back, with the transmittance that is left kept per span. Spans are cut where a layer or a piece
/// begins or ends, at the borders of pixels, and where two surfaces cross, so their order is right
/// everywhere.
///
/// What is left of a span is counted in subpixels, as lengths are: a layer takes its alpha of them, rounded,
/// and what is behind it gets the rest. So weights stay integers and add up exactly, and `k` layers of alpha
/// ½ leave 2^-k of a pixel.
class LayerCompositor {
 public:
  /// A surface's segment. Depth at subpixel x is depth + slope · (x − begin).
  struct Span {
    int32_t begin = 0, end = 0;
    float depth = 0, slope = 0;
    uint32_t index = 0;  ///< Of the triangle in the tile's mesh.
    LinePosition position;

    float DepthAt(int32_t x) const { return depth + slope * float(x - begin); }
  };

  /// For the lines of a tile. `alpha` may be null: layers then hide what their traits say.
  void Begin(const TileMesh& mesh, const AlphaSource* alpha) {
    mesh_ = &mesh;
    alpha_ = alpha;
  }

  /// One line at shutter time t, for `instants` instants: `layers` in any order, over `opaque`, which is in
  /// ascending order without overlap. Goes to the lane of `sums` that has been begun.
  void Composite(std::span<const Span> layers, std::span<const Span> opaque, double t, int64_t instants,
                 int lane, TileColors& colors, LineSums& sums);

 private:
  void CompositeBetween(int32_t begin, int32_t end, const Span* behind);
  void CompositeStep(int32_t begin, int32_t end, const Span* behind);
  void CompositeOrdered(int32_t begin, int32_t end, const Span* behind);
  void CompositeUncrossed(int32_t begin, int32_t end, const Span* behind);
  double AlphaOf(const Span& layer, int32_t begin, int32_t end) const;
  double AlphaAt(const Span& layer, double x) const;
  void AddWhole(int32_t begin, int32_t end, const Span& piece);
  void AddShare(int32_t begin, int32_t end, const Span& surface, const LineSums::PieceShare& share);
  uint16_t BinOf(const Span& surface) const;
  bool IsNearer(const Span& a, const Span& b, int32_t x) const;

  const TileMesh* mesh_ = nullptr;
  const AlphaSource* alpha_ = nullptr;

  // The line in hand.
  TileColors* colors_ = nullptr;
  LineSums* sums_ = nullptr;
  double t_ = 0;
  int64_t instants_ = 1;
  int lane_ = 0;
  std::vector<Span> layers_;       // By begin.
  std::vector<const Span*> over_;  // Those that overlap what is being composited.
  std::vector<int32_t> cuts_;
  std::vector<const Span*> order_;  // Nearest first.
};

}  // namespace shutterline::engine
