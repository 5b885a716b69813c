#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "worker/engine/render/stats.h"
#include "worker/engine/slice/instant_placer.h"
#include "worker/engine/slice/kernels.h"
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

  /// Begins a group of a class of a tile.
  void Begin(const TileMesh& mesh, const LineClass& lines, const LineGroup& group, const Plan& plan,
             TileColors& colors, RenderStats& stats);

  /// The depth below which nothing can be seen anywhere on the lines.
  float hidden_everywhere() const { return hidden_everywhere_; }

  /// Cuts triangles by the lines.
  void Take(const PlacedTriangles& placed);

  /// What has been taken so far stands still: from now on only what is visible of it takes part.
  void EndStatic();

  void BeginInstant();
  /// What is visible at shutter time t, with the triangles taken since BeginInstant, goes to the sums.
  void EndInstant(InstantPlacer& moving, InstantPlacer& still, double t);
  /// At `instants` instants nothing that moves is anywhere near.
  void Rest(int64_t instants);

  /// Hands on what has been seen. `still` holds the triangles that stand still.
  void End(InstantPlacer& still, PairWeights& weights);

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
  void AddPieces(const SegmentLists& lists, uint32_t lanes, const VisiblePieces& pieces, double t,
                 const std::array<int64_t, kLanes>& weights, InstantPlacer* moving, InstantPlacer& still);

  const TileMesh* mesh_ = nullptr;
  const LineClass* lines_ = nullptr;
  const LineGroup* group_ = nullptr;
  TileColors* colors_ = nullptr;
  RenderStats* stats_ = nullptr;
  LineSums sums_;

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
  /// Instants at which nothing that moves is on a lane's stretch.
  std::array<std::array<int64_t, kLanes>, kMostStretches> at_rest_;
};

}  // namespace shutterline::engine
