#include "worker/engine/slice/class_resolver.h"

#include <algorithm>
#include <bit>

namespace shutterline::engine {
namespace {

/// Segments, hidden ones included, that a stretch should get on each lane: marching costs their number times
/// that of the pieces.
constexpr double kSegmentsPerStretch = 24;
/// Where a stretch gets more than so many, most are hidden, and dropping these early saves making others.
constexpr double kManySegments = 48;
constexpr int32_t kFirstBatch = 16;
constexpr int32_t kFirstBatchOfMany = 8;

}  // namespace

void ClassResolver::Resolve(TileStrata& strata, const LineClass& lines, std::span<const double> instants,
                            TileColors& colors, const AlphaSource* alpha, const LineSpread* spread,
                            PairWeights& weights, RenderStats& stats) {
  stats.lines += lines.rows();
  stats.instants += int64_t(instants.size()) * lines.rows();
  group_count_ = lines.groups.size();
  if (groups_.size() < group_count_) groups_.resize(group_count_);
  const GroupResolver::Plan plan = MakePlan(strata, lines);
  for (size_t g = 0; g < group_count_; ++g) {
    groups_[g].Begin(strata.mesh(), lines, lines.groups[g], plan, colors, alpha, spread, stats);
  }

  still_.Begin(strata.still(), lines, 0.5);
  PlaceAll(still_);
  const bool has_layers = strata.mesh().has_layers();
  if (has_layers) {
    still_layers_.Begin(strata.still_layers(), lines, 0.5);
    PlaceLayers(still_layers_);
  }
  for (size_t g = 0; g < group_count_; ++g) groups_[g].EndStatic();

  if (!strata.moves()) {
    for (size_t g = 0; g < group_count_; ++g) groups_[g].Rest(int64_t(instants.size()));
  } else {
    for (const double t : instants) ResolveInstant(strata, lines, t);
  }
  for (size_t g = 0; g < group_count_; ++g)
    groups_[g].End({.still = &still_, .still_layers = &still_layers_}, weights);
}

GroupResolver::Plan ClassResolver::MakePlan(const TileStrata& strata, const LineClass& lines) {
  const double per_line = strata.SegmentsPerLine(size_t(lines.family));
  const int length_log2 = std::bit_width(uint32_t(lines.length - 1));
  int log2 = 0;
  while (length_log2 - log2 > GroupResolver::kShortestStretchLog2 &&
         per_line / double(1 << log2) > kSegmentsPerStretch) {
    ++log2;
  }
  const bool are_many = per_line / double(1 << log2) > kManySegments;
  return {.stretches = 1 << log2, .first_batch = are_many ? kFirstBatchOfMany : kFirstBatch};
}

void ClassResolver::PlaceAll(InstantPlacer& placer) {
  for (;;) {
    float hidden = groups_[0].hidden_everywhere();
    for (size_t g = 1; g < group_count_; ++g) hidden = std::min(hidden, groups_[g].hidden_everywhere());
    const float nearest = placer.nearest_left();
    if (nearest < hidden || !placer.PlaceNext()) return;
    for (size_t g = 0; g < group_count_; ++g) {
      if (nearest >= groups_[g].hidden_everywhere()) groups_[g].Take(placer.placed());
    }
  }
}

void ClassResolver::PlaceLayers(InstantPlacer& placer) {
  // What is opaque has been placed: the depth behind which nothing shows is known.
  while (placer.PlaceNext()) {
    for (size_t g = 0; g < group_count_; ++g) groups_[g].TakeLayers(placer.placed());
  }
}

void ClassResolver::ResolveInstant(TileStrata& strata, const LineClass& lines, double t) {
  Stratum& stratum = strata.At(t);
  const bool has_layers = strata.mesh().has_layers();
  if (stratum.empty() && !(has_layers && !strata.LayersAt(t).empty())) {
    for (size_t g = 0; g < group_count_; ++g) groups_[g].Rest(1);
    return;
  }
  for (size_t g = 0; g < group_count_; ++g) groups_[g].BeginInstant();
  moving_.Begin(stratum, lines, t);
  PlaceAll(moving_);
  if (has_layers) {
    moving_layers_.Begin(strata.LayersAt(t), lines, t);
    PlaceLayers(moving_layers_);
  }
  const GroupResolver::Placers placers{&still_, &moving_, &still_layers_, &moving_layers_};
  for (size_t g = 0; g < group_count_; ++g) groups_[g].EndInstant(placers, t);
}

}  // namespace shutterline::engine
