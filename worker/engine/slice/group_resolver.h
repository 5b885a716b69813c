#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "worker/engine/render/stats.h"
#include "worker/engine/slice/instant_placer.h"
#include "worker/engine/slice/kernels.h"
#include "worker/engine/slice/layer_compositor.h"
#include "worker/engine/slice/line_class.h"
#include "worker/engine/slice/line_sums.h"
#include "worker/engine/slice/segment_lists.h"

namespace shutterline::engine {

/// Resolves one group of lines, in stretches of the lines that are short enough for their lists to be. It is
/// handed placed triangles: once those that stand still, then, instant by instant, those that move. Keeps its
/// memory.
class GroupResolver {
 public:
  /// How a group's lists are kept short.
  struct Plan {
    int stretches = 1;        ///< Into which lines are cut: a power of two.
    int32_t first_batch = 8;  ///< Segments that a list takes before what is hidden among them is dropped.
  };

  /// Who knows where on a triangle a line's points lie, by what it is; null where there is none of its kind.
  struct Placers {
    InstantPlacer* still = nullptr;
    InstantPlacer* moving = nullptr;
    InstantPlacer* still_layers = nullptr;
    InstantPlacer* moving_layers = nullptr;

    InstantPlacer& Of(const TileMeshTriangle& triangle) const {
      if (triangle.layer) return triangle.moves ? *moving_layers : *still_layers;
      return triangle.moves ? *moving : *still;
    }
  };

  /// Begins a group of a class of a tile. `alpha` may be null, see LayerCompositor, and so may `spread`, see
  /// LineSums.
  void Begin(const TileMesh& mesh, const LineClass& lines, const LineGroup& group, const Plan& plan,
             TileColors& colors, const AlphaSource* alpha, const LineSpread* spread, RenderStats& stats);

  /// The depth below which nothing can be seen anywhere on the lines.
  float hidden_everywhere() const { return hidden_everywhere_; }

  /// Cuts triangles by the lines.
  void Take(const PlacedTriangles& placed);

  /// The same with layers, which hide nothing: after what is opaque has been taken.
  void TakeLayers(const PlacedTriangles& placed);

  /// What has been taken so far stands still: from now on only what is visible of it takes part.
  void EndStatic();

  void BeginInstant();
  /// What is visible at shutter time t, with the triangles taken since BeginInstant, goes to the sums.
  void EndInstant(const Placers& placers, double t);
  /// At `instants` instants nothing that moves is anywhere near.
  void Rest(int64_t instants);

  /// Hands on what has been seen. `placers` has those of what stands still.
  void End(const Placers& placers, PairWeights& weights);

  /// Lines are at most kMaxLinePixels long and stretches at least kShortestStretch.
  static constexpr int kShortestStretchLog2 = 2;
  static constexpr int kMostStretches = 1 << (kMaxLinePixelsLog2 - kShortestStretchLog2);

 private:
  /// The length at which a list that has just been compacted to `rows` is next. Doubling keeps the work of
  /// all compactions within a constant factor of the last one.
  int32_t CompactAt(int32_t rows) const { return std::max(rows + first_batch_, 2 * rows); }

  /// Drops what is hidden in a stretch, and notes what is hidden behind the rest.
  void Compact(int stretch);
  void UpdateHiddenEverywhere();
  void AddPieces(const SegmentLists& lists, const SegmentLists& layers, uint32_t lanes,
                 const VisiblePieces& pieces, double t, const std::array<int64_t, kLanes>& weights,
                 const Placers& placers) {
    if (spreads_) return AddPiecesTo<true>(lists, layers, lanes, pieces, t, weights, placers);
    AddPiecesTo<false>(lists, layers, lanes, pieces, t, weights, placers);
  }
  template <bool kSpread>
  void AddPiecesTo(const SegmentLists& lists, const SegmentLists& layers, uint32_t lanes,
                   const VisiblePieces& pieces, double t, const std::array<int64_t, kLanes>& weights,
                   const Placers& placers);
  /// The part [begin, end) of an entry of a lane's list.
  LayerCompositor::Span SpanOf(const SegmentLists& lists, int lane, int32_t entry, int32_t begin, int32_t end,
                               const Placers& placers);
  /// The lane's layers to layers_of_lane_; false if it has none.
  bool GatherLayers(const SegmentLists& layers, int lane, const Placers& placers);

  const TileMesh* mesh_ = nullptr;
  const LineClass* lines_ = nullptr;
  const LineGroup* group_ = nullptr;
  TileColors* colors_ = nullptr;
  RenderStats* stats_ = nullptr;
  LineSums sums_;
  bool spreads_ = false;

  int stretches_ = 1;
  int32_t first_batch_ = 0;
  int shift_ = 0;
  std::array<SegmentLists, kMostStretches> lists_;
  std::array<HiddenBelow, kMostStretches> hidden_below_{};
  float hidden_everywhere_ = 0;
  VisiblePieces pieces_;

  // Of Compact.
  VisiblePieces compaction_;
  SegmentLists compacted_;
  std::vector<int32_t> new_entry_;

  // What is visible of what stands still, if nothing else is there.
  std::array<SegmentLists, kMostStretches> static_lists_;
  std::array<VisiblePieces, kMostStretches> static_pieces_;
  std::array<HiddenBelow, kMostStretches> static_hidden_below_{};
  float static_hidden_everywhere_ = 0;
  std::array<bool, kMostStretches> holds_static_{};  // lists_ begins with static_lists_.

  // Layers, where the tile has any: those that stand still in the first rows.
  LayerCompositor compositor_;
  std::array<SegmentLists, kMostStretches> layers_, static_layers_;
  std::vector<LayerCompositor::Span> layers_of_lane_, pieces_of_lane_;
  /// Instants at which nothing that moves is on a lane's stretch.
  std::array<std::array<int64_t, kLanes>, kMostStretches> at_rest_;
};

}  // namespace shutterline::engine
