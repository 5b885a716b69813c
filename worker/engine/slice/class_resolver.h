#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "worker/engine/slice/group_resolver.h"
#include "worker/engine/slice/instant_placer.h"
#include "worker/engine/slice/tile_strata.h"

namespace shutterline::engine {

/// Resolves one class of lines of a tile: what stands still once, then every instant, front to back. Keeps
/// its memory; one per thread.
class ClassResolver {
 public:
  /// `instants`: the times at which what moves is resolved; each weighs 1. `spread`: null without a filter.
  void Resolve(TileStrata& strata, const LineClass& lines, std::span<const double> instants,
               TileColors& colors, const AlphaSource* alpha, const LineSpread* spread, PairWeights& weights,
               RenderStats& stats);

 private:
  static GroupResolver::Plan MakePlan(const TileStrata& strata, const LineClass& lines);
  void ResolveInstant(TileStrata& strata, const LineClass& lines, double t);
  /// Hands out what the placer has left to place, nearest first, until nothing more of it can be seen.
  void PlaceAll(InstantPlacer& placer);
  void PlaceLayers(InstantPlacer& placer);

  std::vector<GroupResolver> groups_;
  size_t group_count_ = 0;
  InstantPlacer still_, moving_, still_layers_, moving_layers_;
};

}  // namespace shutterline::engine
