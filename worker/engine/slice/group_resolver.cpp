#include "worker/engine/slice/group_resolver.h"

#include <bit>
#include <limits>

namespace shutterline::engine {
namespace {

constexpr float kNothingHidden = -std::numeric_limits<float>::infinity();
constexpr float kEverythingHidden = std::numeric_limits<float>::infinity();
constexpr int32_t kNever = std::numeric_limits<int32_t>::max();
constexpr uint32_t kAllLanes = (uint32_t{1} << kLanes) - 1;

constexpr auto kOnce = [] {
  std::array<int64_t, kLanes> once{};
  once.fill(1);
  return once;
}();

}  // namespace

void GroupResolver::Begin(const TileMesh& mesh, const LineClass& lines, const LineGroup& group,
                          const Plan& plan, TileColors& colors, const AlphaSource* alpha,
                          const LineSpread* spread, RenderStats& stats) {
  mesh_ = &mesh;
  lines_ = &lines;
  group_ = &group;
  colors_ = &colors;
  stats_ = &stats;
  sums_.Begin(mesh, lines, group, colors, spread);
  spreads_ = spread != nullptr;

  stretches_ = plan.stretches;
  first_batch_ = plan.first_batch;
  const int length_log2 = std::bit_width(uint32_t(lines.length - 1));
  shift_ = kSubpixelBits + length_log2 - std::countr_zero(uint32_t(stretches_));
  for (int k = 0; k < stretches_; ++k) {
    SegmentLists& lists = lists_[size_t(k)];
    lists.stretch_begin = static_lists_[size_t(k)].stretch_begin = k << shift_;
    lists.stretch_end = static_lists_[size_t(k)].stretch_end = (k + 1) << shift_;
    lists.Clear();
    lists.compact_at = CompactAt(0);
    static_lists_[size_t(k)].Clear();
    static_pieces_[size_t(k)].rows = 0;
    HiddenBelow& hidden = hidden_below_[size_t(k)];
    for (size_t lane = 0; lane < kLanes; ++lane) {
      const bool is_line =
          std::max(group_->begin[lane], lists.stretch_begin) < std::min(group_->end[lane], lists.stretch_end);
      hidden.lanes[lane] = is_line ? kNothingHidden : kEverythingHidden;
    }
    hidden.UpdateAll();
    static_hidden_below_[size_t(k)] = hidden;
    holds_static_[size_t(k)] = false;
    at_rest_[size_t(k)].fill(0);
  }
  hidden_everywhere_ = static_hidden_everywhere_ = kNothingHidden;
  if (!mesh.has_layers()) return;
  compositor_.Begin(mesh, alpha);
  for (int k = 0; k < stretches_; ++k) {
    SegmentLists& layers = layers_[size_t(k)];
    layers.stretch_begin = static_layers_[size_t(k)].stretch_begin = k << shift_;
    layers.stretch_end = static_layers_[size_t(k)].stretch_end = (k + 1) << shift_;
    layers.compact_at = kNever;
    layers.Clear();
    static_layers_[size_t(k)].Clear();
  }
}

void GroupResolver::Take(const PlacedTriangles& placed) {
  Stretches stretches{.lists = {lists_.data(), size_t(stretches_)},
                      .shift = shift_,
                      .hidden_below = {hidden_below_.data(), size_t(stretches_)}};
  for (size_t next = 0; next < placed.met_count;) {
    next = MakeSegments(placed, next, *group_, stretches, stats_->segments);
    for (int k = 0; k < stretches_; ++k) {
      if (lists_[size_t(k)].rows >= lists_[size_t(k)].compact_at) Compact(k);
    }
  }
}

void GroupResolver::TakeLayers(const PlacedTriangles& placed) {
  Stretches stretches{.lists = {layers_.data(), size_t(stretches_)},
                      .shift = shift_,
                      .hidden_below = {hidden_below_.data(), size_t(stretches_)}};
  for (size_t next = 0; next < placed.met_count;) {
    next = MakeSegments(placed, next, *group_, stretches, stats_->segments);
  }
}

void GroupResolver::EndStatic() {
  if (mesh_->has_layers()) {
    for (int k = 0; k < stretches_; ++k) static_layers_[size_t(k)].StartFrom(layers_[size_t(k)]);
  }
  for (int k = 0; k < stretches_; ++k) {
    if (lists_[size_t(k)].touched == 0) continue;
    Compact(k);
    std::swap(lists_[size_t(k)], static_lists_[size_t(k)]);
    std::swap(compaction_, static_pieces_[size_t(k)]);
    static_hidden_below_[size_t(k)] = hidden_below_[size_t(k)];
  }
  static_hidden_everywhere_ = hidden_everywhere_;
}

void GroupResolver::UpdateHiddenEverywhere() {
  float hidden = kEverythingHidden;
  for (int k = 0; k < stretches_; ++k) hidden = std::min(hidden, hidden_below_[size_t(k)].all);
  hidden_everywhere_ = hidden;
}

void GroupResolver::BeginInstant() {
  for (int k = 0; k < stretches_; ++k) {
    SegmentLists& lists = lists_[size_t(k)];
    if (!holds_static_[size_t(k)]) {
      lists.StartFrom(static_lists_[size_t(k)]);
      holds_static_[size_t(k)] = true;
    }
    lists.Truncate(static_lists_[size_t(k)].rows);
    lists.compact_at = CompactAt(lists.rows);
    hidden_below_[size_t(k)] = static_hidden_below_[size_t(k)];
    if (mesh_->has_layers()) layers_[size_t(k)].Truncate(static_layers_[size_t(k)].rows);
  }
  hidden_everywhere_ = static_hidden_everywhere_;
}

void GroupResolver::EndInstant(const Placers& placers, double t) {
  for (int k = 0; k < stretches_; ++k) {
    const SegmentLists& lists = lists_[size_t(k)];
    const SegmentLists& layers = layers_[size_t(k)];
    const uint32_t touched = mesh_->has_layers() ? lists.touched | layers.touched : lists.touched;
    for (int lane = 0; lane < group_->lanes; ++lane) {
      if ((touched >> lane & 1) == 0) ++at_rest_[size_t(k)][size_t(lane)];
    }
    if (touched == 0) continue;
    March(lists, mesh_->ids().data(), *group_, touched, pieces_);
    AddPieces(lists, layers, touched, pieces_, t, kOnce, placers);
  }
}

void GroupResolver::Rest(int64_t instants) {
  for (int k = 0; k < stretches_; ++k) {
    for (int64_t& count : at_rest_[size_t(k)]) count += instants;
  }
}

void GroupResolver::End(const Placers& placers, PairWeights& weights) {
  for (int k = 0; k < stretches_; ++k) {
    AddPieces(static_lists_[size_t(k)], static_layers_[size_t(k)], kAllLanes, static_pieces_[size_t(k)], 0,
              at_rest_[size_t(k)], placers);
  }
  sums_.End(weights);
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
      float& hidden = hidden_below_[size_t(stretch)].lanes[size_t(lane)];
      hidden = std::max(hidden, farthest);
    }
  }
  compacted_.compact_at = CompactAt(compacted_.rows);
  compacted_.stretch_begin = lists.stretch_begin;
  compacted_.stretch_end = lists.stretch_end;
  compacted_.touched = lists.touched;
  std::swap(lists, compacted_);
  holds_static_[size_t(stretch)] = false;
  hidden_below_[size_t(stretch)].UpdateAll();
  UpdateHiddenEverywhere();
}

LayerCompositor::Span GroupResolver::SpanOf(const SegmentLists& lists, int lane, int32_t entry, int32_t begin,
                                            int32_t end, const Placers& placers) {
  const size_t at = size_t(entry) * kLanes + size_t(lane);
  LayerCompositor::Span span{.begin = begin,
                             .end = end,
                             .depth = 0,
                             .slope = lists.slope[at],
                             .index = lists.index[at],
                             .position = {}};
  span.depth = lists.depth[at] + span.slope * float(begin - lists.begin[at]);
  const TileMeshTriangle& triangle = mesh_->triangles()[span.index];
  if (triangle.needs_position) {
    span.position = placers.Of(triangle).PositionOn(span.index, group_->first_row + lane);
  }
  return span;
}

bool GroupResolver::GatherLayers(const SegmentLists& layers, int lane, const Placers& placers) {
  layers_of_lane_.clear();
  const int32_t from = std::max(group_->begin[size_t(lane)], layers.stretch_begin);
  const int32_t to = std::min(group_->end[size_t(lane)], layers.stretch_end);
  for (int32_t r = 0; r < layers.rows; ++r) {
    const size_t at = size_t(r) * kLanes + size_t(lane);
    const int32_t begin = std::max(layers.begin[at], from), end = std::min(layers.end[at], to);
    if (begin < end) layers_of_lane_.push_back(SpanOf(layers, lane, r, begin, end, placers));
  }
  return !layers_of_lane_.empty();
}

template <bool kSpread>
void GroupResolver::AddPiecesTo(const SegmentLists& lists, const SegmentLists& layers, uint32_t lanes,
                                const VisiblePieces& pieces, double t,
                                const std::array<int64_t, kLanes>& weights, const Placers& placers) {
  for (int lane = 0; lane < group_->lanes; ++lane) {
    const int64_t weight = weights[size_t(lane)];
    if ((lanes >> lane & 1) == 0 || weight == 0) continue;
    sums_.BeginLane<kSpread>(lane, double(weight));
    const bool is_layered = mesh_->has_layers() && GatherLayers(layers, lane, placers);
    pieces_of_lane_.clear();
    for (int32_t r = 0; r < pieces.rows; ++r) {
      const size_t at = size_t(r) * kLanes + size_t(lane);
      const int32_t begin = pieces.begin[at];
      const int32_t end = pieces.end[at];
      if (begin >= end) continue;
      ++stats_->spans;
      if (is_layered) {
        pieces_of_lane_.push_back(SpanOf(lists, lane, pieces.entry[at], begin, end, placers));
        continue;
      }
      const uint32_t index = lists.index[size_t(pieces.entry[at]) * kLanes + size_t(lane)];
      const ColorKind kind = colors_->KindOf(index);
      if (kind == ColorKind::kConstant) {
        sums_.AddFlat<kSpread>(begin, end, index);
        if (!colors_->keeps_pairs()) continue;
      }
      const TileMeshTriangle& triangle = mesh_->triangles()[index];
      LinePosition position;
      if (triangle.needs_position) {
        position = placers.Of(triangle).PositionOn(index, group_->first_row + lane);
      }
      if (kind == ColorKind::kSmooth) {
        sums_.AddSmooth(begin, end, index, position);
        if (!colors_->keeps_pairs()) continue;
      }
      const auto bin = uint16_t(t * double(1u << triangle.shading_bins_log2));
      sums_.AddApart(lane, begin, end, index, bin, weight, position);
    }
    if (is_layered) {
      compositor_.Composite(layers_of_lane_, pieces_of_lane_, t, weight, lane, *colors_, sums_);
    }
    sums_.EndLane<kSpread>();
  }
}

}  // namespace shutterline::engine
