#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "worker/engine/render/stats.h"
#include "worker/engine/slice/line_group.h"
#include "worker/engine/slice/line_sums.h"
#include "worker/engine/slice/segment_lists.h"
#include "worker/engine/slice/stratum.h"
#include "worker/engine/slice/tile_mesh.h"
#include "worker/engine/visibility/time_samples.h"

namespace shutterline::engine {

/// Resolves one group of lines of a tile: what stands still once, then every instant, front to back, in
/// stretches of the lines that are short enough for their lists to be. Keeps its memory; one per thread.
class GroupResolver {
 public:
  void Resolve(const TileMesh& mesh, const LineGroup& group, const TimeSamples& time_samples, LineSums& sums,
               RenderStats& stats);

 private:
  /// Lines are at most kMaxLinePixels long and stretches at least kShortestStretch.
  static constexpr int kShortestStretchLog2 = 2;
  static constexpr int kMostStretches = 1 << (kMaxLinePixelsLog2 - kShortestStretchLog2);
  /// Segments that a list takes before what is hidden among them is dropped.
  static constexpr int32_t kFirstBatch = 8;
  /// The length at which a list that has just been compacted to `rows` is next. Doubling keeps the work of
  /// all compactions within a constant factor of the last one.
  static constexpr int32_t CompactAt(int32_t rows) { return std::max(rows + kFirstBatch, 2 * rows); }

  void GatherTriangles();
  void ChooseStretches();
  void ResolveStatic();
  void KeepVisibleMoving();
  void ResolveInstants(int64_t instants, double motion);
  void ResolveInstant(double t);
  /// Cuts all triangles of a stratum, at its instant, into lists_.
  void FillLists(Stratum& stratum);
  void Append(const GroupTriangles& triangles, const PlacedTriangles& placed);
  /// The depth below which nothing can be seen anywhere on the lines.
  float HiddenEverywhere() const;
  /// Drops what is hidden in a stretch, and notes what is hidden behind the rest.
  void Compact(int stretch);
  void AddPieces(const SegmentLists& lists, uint32_t lanes, const VisiblePieces& pieces, double t,
                 const std::array<int64_t, kLanes>& weights);
  void AddPiece(int lane, int32_t begin, int32_t end, uint32_t index, double t, int64_t weight);

  const TileMesh* mesh_ = nullptr;
  const LineGroup* group_ = nullptr;
  LineSums* sums_ = nullptr;
  RenderStats* stats_ = nullptr;

  std::vector<uint32_t> static_indices_, moving_indices_;
  Stratum static_stratum_, moving_stratum_;

  int stretches_ = 1;
  int shift_ = 0;
  std::array<SegmentLists, kMostStretches> lists_;
  std::array<HiddenBelow, kMostStretches> hidden_below_{};
  VisiblePieces pieces_;

  // Of Compact.
  VisiblePieces compaction_;
  SegmentLists compacted_;
  std::vector<int32_t> new_entry_;

  // What is visible of what stands still, if nothing else is there.
  std::array<SegmentLists, kMostStretches> static_lists_;
  std::array<VisiblePieces, kMostStretches> static_pieces_;
  std::array<HiddenBelow, kMostStretches> static_hidden_below_{};
  std::array<bool, kMostStretches> holds_static_{};  // lists_ begins with static_lists_.
  /// Instants at which nothing that moves is on a lane's stretch.
  std::array<std::array<int64_t, kLanes>, kMostStretches> at_rest_;
};

}  // namespace shutterline::engine
