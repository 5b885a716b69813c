#pragma once

#include "worker/engine/visibility/resolver.h"
#include "worker/engine/visibility/time_samples.h"

namespace shutterline::engine {

/// Exact along a line, stratified in time: at an instant a moving triangle is a static one, and on a
/// line it is one segment whose depth is exactly linear. So each line is resolved exactly at as many
/// stratified instants as its motion asks for. Departs from [gribel2011, section 5], which approximates
/// what a triangle covers over time by patch triangles and sorts these; see docs/math/line_samples.md.
///
/// What stands still is resolved once per line: only the static triangles that are visible among the
/// static ones take part at the instants, and where nothing moves there is a single instant.
class ResolverSlice final : public Resolver {
 public:
  ResolverSlice(const LinePattern& pattern, const RenderSettings& settings);

  void Resolve(const TileTriangles& tile, PairWeights& weights, RenderStats& stats) const override;

 private:
  const LinePattern& pattern_;
  TimeSamples time_samples_;
};

}  // namespace shutterline::engine
