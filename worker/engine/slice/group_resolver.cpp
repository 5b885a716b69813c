#include "worker/engine/slice/group_resolver.h"

#include <algorithm>
#include <limits>

#include "worker/engine/slice/kernels.h"

namespace shutterline::engine {
namespace {

constexpr float kNothingHidden = -std::numeric_limits<float>::infinity();
constexpr float kEverythingHidden = std::numeric_limits<float>::infinity();
constexpr uint32_t kAllLanes = (uint32_t{1} << kLanes) - 1;
/// The shutter is cut where things have moved on by about so many pixels, and triangles are gathered anew:
/// what is on the lines for a short while is then looked at for a short while only, which keeps the price
/// linear in the length of the motion.
constexpr double kPixelsPerStratum = 32;
constexpr int64_t kLeastPerStratum = 4;
/// Segments that a stretch should hold on each lane: marching costs their number times that of the pieces.
constexpr double kSegmentsPerStretch = 12;

}  // namespace

void GroupResolver::Resolve(const TileMesh& mesh, const LineGroup& group, const TimeSamples& time_samples,
                            LineSums& sums, RenderStats& stats) {
  mesh_ = &mesh;
  group_ = &group;
  sums_ = &sums;
  stats_ = &stats;
  stats.lines += group.lanes;
  GatherTriangles();
  if (static_indices_.empty() && moving_indices_.empty()) return;
  sums.BeginGroup(group);
  ChooseStretches();
  ResolveStatic();
  KeepVisibleMoving();

  double motion = 0;
  for (const uint32_t index : moving_indices_) {
    motion = std::max(motion, double(mesh.triangles()[index].motion_pixels));
  }
  const int64_t instants = moving_indices_.empty() ? 1 : time_samples.InstantsFor(motion);
  stats.instants += instants * group.lanes;
  for (int k = 0; k < stretches_; ++k) at_rest_[size_t(k)].fill(moving_indices_.empty() ? 1 : 0);
  if (!moving_indices_.empty()) ResolveInstants(instants, motion);
  for (int k = 0; k < stretches_; ++k) {
    AddPieces(static_lists_[size_t(k)], kAllLanes, static_pieces_[size_t(k)], 0, at_rest_[size_t(k)]);
  }
  sums.EndGroup(time_samples.WeightOf(instants));
}

void GroupResolver::GatherTriangles() {
  const auto family = size_t(group_->family);
  const double low = group_->intercept;
  const double high = group_->intercept + (group_->lanes - 1);
  static_indices_.clear();
  moving_indices_.clear();
  const std::vector<TileMeshTriangle>& triangles = mesh_->triangles();
  for (uint32_t i = 0; i < triangles.size(); ++i) {
    if (triangles[i].row_low[family] > high || triangles[i].row_high[family] < low) continue;
    (triangles[i].moves ? moving_indices_ : static_indices_).push_back(i);
  }
}

void GroupResolver::ChooseStretches() {
  // The triangles' extent across the lines tells how many segments a lane gets, about.
  const auto family = size_t(group_->family);
  double segments = 0;
  for (const auto* indices : {&static_indices_, &moving_indices_}) {
    for (const uint32_t i : *indices) {
      const TileMeshTriangle& triangle = mesh_->triangles()[i];
      const double rows = std::min(triangle.row_high[family], group_->intercept + group_->lanes) -
                          std::max(triangle.row_low[family], group_->intercept - 1);
      const double share = triangle.moves ? std::min(1.0, (triangle.t_out - triangle.t_in)) : 1;
      segments += std::clamp(rows, 0.5, double(group_->lanes)) * share;
    }
  }
  const int length = group_->major_is_x ? mesh_->rect().width : mesh_->rect().height;
  int log2 = 0;
  while ((1 << log2) < length) ++log2;
  const double per_lane = segments / group_->lanes;
  int stretch_log2 = log2;
  while (stretch_log2 > kShortestStretchLog2 &&
         per_lane / double(1 << (log2 - stretch_log2)) > kSegmentsPerStretch) {
    --stretch_log2;
  }
  shift_ = kSubpixelBits + stretch_log2;
  stretches_ = 1 << (log2 - stretch_log2);
  for (int k = 0; k < stretches_; ++k) {
    lists_[size_t(k)].stretch_begin = k << shift_;
    lists_[size_t(k)].stretch_end = (k + 1) << shift_;
    static_lists_[size_t(k)].stretch_begin = k << shift_;
    static_lists_[size_t(k)].stretch_end = (k + 1) << shift_;
  }
}

void GroupResolver::ResolveStatic() {
  for (int k = 0; k < stretches_; ++k) {
    lists_[size_t(k)].Clear();
    lists_[size_t(k)].compact_at = CompactAt(0);
    static_lists_[size_t(k)].Clear();
    static_pieces_[size_t(k)].rows = 0;
    HiddenBelow& hidden = hidden_below_[size_t(k)];
    for (size_t lane = 0; lane < kLanes; ++lane) {
      const bool is_line = std::max(group_->begin[lane], lists_[size_t(k)].stretch_begin) <
                           std::min(group_->end[lane], lists_[size_t(k)].stretch_end);
      hidden[lane] = is_line ? kNothingHidden : kEverythingHidden;
    }
    static_hidden_below_[size_t(k)] = hidden;
    holds_static_[size_t(k)] = false;
  }
  if (static_indices_.empty()) return;
  static_stratum_.Build(*mesh_, *group_, static_indices_, 0, 1);
  static_stratum_.BeginInstant(0.5);
  FillLists(static_stratum_);
  for (int k = 0; k < stretches_; ++k) {
    Compact(k);
    std::swap(lists_[size_t(k)], static_lists_[size_t(k)]);
    std::swap(compaction_, static_pieces_[size_t(k)]);
    static_hidden_below_[size_t(k)] = hidden_below_[size_t(k)];
  }
}

float GroupResolver::HiddenEverywhere() const {
  float hidden = std::numeric_limits<float>::infinity();
  for (int k = 0; k < stretches_; ++k) {
    const HiddenBelow& below = hidden_below_[size_t(k)];
    hidden = std::min(hidden, *std::min_element(below.begin(), below.begin() + group_->lanes));
  }
  return hidden;
}

void GroupResolver::KeepVisibleMoving() {
  const float hidden = HiddenEverywhere();
  size_t kept = 0;
  while (kept < moving_indices_.size() && mesh_->triangles()[moving_indices_[kept]].nearest >= hidden) ++kept;
  moving_indices_.resize(kept);
}

void GroupResolver::ResolveInstants(int64_t instants, double motion) {
  const int64_t per_stratum =
      std::max(kLeastPerStratum, int64_t(double(instants) * kPixelsPerStratum / std::max(motion, 1.0)));
  for (int64_t first = 0; first < instants; first += per_stratum) {
    const int64_t end = std::min(instants, first + per_stratum);
    const double offset = group_->instant_offset;
    moving_stratum_.Build(*mesh_, *group_, moving_indices_, TimeSamples::InstantAt(first, instants, offset),
                          TimeSamples::InstantAt(end - 1, instants, offset));
    if (moving_stratum_.empty()) {
      for (int k = 0; k < stretches_; ++k) {
        for (int64_t& count : at_rest_[size_t(k)]) count += end - first;
      }
      continue;
    }
    for (int64_t i = first; i < end; ++i) ResolveInstant(TimeSamples::InstantAt(i, instants, offset));
  }
}

void GroupResolver::ResolveInstant(double t) {
  moving_stratum_.BeginInstant(t);
  for (int k = 0; k < stretches_; ++k) {
    SegmentLists& lists = lists_[size_t(k)];
    if (!holds_static_[size_t(k)]) {
      lists = static_lists_[size_t(k)];
      holds_static_[size_t(k)] = true;
    }
    lists.Truncate(static_lists_[size_t(k)].rows);
    lists.compact_at = CompactAt(lists.rows);
    hidden_below_[size_t(k)] = static_hidden_below_[size_t(k)];
  }
  FillLists(moving_stratum_);

  static constexpr auto kOnce = [] {
    std::array<int64_t, kLanes> once{};
    once.fill(1);
    return once;
  }();
  for (int k = 0; k < stretches_; ++k) {
    const SegmentLists& lists = lists_[size_t(k)];
    for (int lane = 0; lane < group_->lanes; ++lane) {
      if ((lists.touched >> lane & 1) == 0) ++at_rest_[size_t(k)][size_t(lane)];
    }
    if (lists.touched == 0) continue;
    March(lists, mesh_->ids().data(), *group_, lists.touched, pieces_);
    AddPieces(lists, lists.touched, pieces_, t, kOnce);
  }
}

void GroupResolver::FillLists(Stratum& stratum) {
  while (stratum.nearest_left() >= HiddenEverywhere() && stratum.PlaceNextBlock()) {
    Append(stratum.triangles(), stratum.placed());
    if (stratum.clipped_triangles().count > 0) {
      Append(stratum.clipped_triangles(), stratum.clipped_placed());
    }
  }
}

void GroupResolver::Append(const GroupTriangles& triangles, const PlacedTriangles& placed) {
  Stretches stretches{.lists = {lists_.data(), size_t(stretches_)},
                      .shift = shift_,
                      .hidden_below = {hidden_below_.data(), size_t(stretches_)}};
  for (size_t next = 0; next < placed.met.size();) {
    next = MakeSegments(triangles, placed, next, *group_, stretches, stats_->segments);
    for (int k = 0; k < stretches_; ++k) {
      if (lists_[size_t(k)].rows >= lists_[size_t(k)].compact_at) Compact(k);
    }
  }
}

void GroupResolver::Compact(int stretch) {
  SegmentLists& lists = lists_[size_t(stretch)];
  VisiblePieces& pieces = compaction_;
  March(lists, mesh_->ids().data(), *group_, kAllLanes, pieces);
  compacted_.Clear();
  for (int lane = 0; lane < group_->lanes; ++lane) {
    const int32_t from = std::max(group_->begin[size_t(lane)], lists.stretch_begin);
    const int32_t to = std::min(group_->end[size_t(lane)], lists.stretch_end);
    int64_t covered = 0;
    float farthest = std::numeric_limits<float>::infinity();
    new_entry_.assign(size_t(lists.rows), -1);
    for (int32_t r = 0; r < pieces.rows; ++r) {
      const size_t at = size_t(r) * kLanes + size_t(lane);
      const int32_t begin = pieces.begin[at];
      const int32_t end = pieces.end[at];
      if (begin >= end) continue;
      // What is visible is kept as it is, so that it does not matter when this happens.
      int32_t& entry = new_entry_[size_t(pieces.entry[at])];
      const size_t source = size_t(pieces.entry[at]) * kLanes + size_t(lane);
      const float slope = lists.slope[source];
      if (entry < 0) {
        entry = compacted_.count[size_t(lane)];
        compacted_.Append(lane, lists.begin[source], lists.end[source], lists.depth[source], slope,
                          lists.index[source]);
      }
      pieces.entry[at] = entry;
      covered += end - begin;
      farthest = std::min({farthest, lists.depth[source] + slope * float(begin - lists.begin[source]),
                           lists.depth[source] + slope * float(end - lists.begin[source])});
    }
    // Without a gap, the farthest visible depth hides all that lies behind it.
    if (covered >= to - from) {
      float& hidden = hidden_below_[size_t(stretch)][size_t(lane)];
      hidden = std::max(hidden, farthest);
    }
  }
  compacted_.compact_at = CompactAt(compacted_.rows);
  compacted_.stretch_begin = lists.stretch_begin;
  compacted_.stretch_end = lists.stretch_end;
  compacted_.touched = lists.touched;
  std::swap(lists, compacted_);
  holds_static_[size_t(stretch)] = false;
}

void GroupResolver::AddPieces(const SegmentLists& lists, uint32_t lanes, const VisiblePieces& pieces,
                              double t, const std::array<int64_t, kLanes>& weights) {
  for (int lane = 0; lane < group_->lanes; ++lane) {
    if ((lanes >> lane & 1) == 0 || weights[size_t(lane)] == 0) continue;
    sums_->BeginLane(lane, double(weights[size_t(lane)]));
    for (int32_t r = 0; r < pieces.rows; ++r) {
      const size_t at = size_t(r) * kLanes + size_t(lane);
      if (pieces.begin[at] >= pieces.end[at]) continue;
      const size_t entry = size_t(pieces.entry[at]) * kLanes + size_t(lane);
      AddPiece(lane, pieces.begin[at], pieces.end[at], lists.index[entry], t, weights[size_t(lane)]);
    }
    sums_->EndLane();
  }
}

void GroupResolver::AddPiece(int lane, int32_t begin, int32_t end, uint32_t index, double t, int64_t weight) {
  ++stats_->spans;
  const ColorKind kind = sums_->KindOf(index);
  if (kind == ColorKind::kConstant) {
    sums_->AddFlat(begin, end, index);
    return;
  }
  const TileMeshTriangle& triangle = mesh_->triangles()[index];
  LinePosition position;
  if (triangle.needs_position) {
    position = (triangle.moves ? moving_stratum_ : static_stratum_).PositionOn(index, lane);
  }
  if (kind == ColorKind::kSmooth) {
    sums_->AddSmooth(begin, end, index, position);
    return;
  }
  const auto bin = uint16_t(t * double(1u << triangle.shading_bins_log2));
  sums_->AddApart(lane, begin, end, index, bin, weight, position);
}

}  // namespace shutterline::engine
