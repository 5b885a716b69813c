#pragma once

#include "common/job/render_settings.h"
#include "worker/engine/sampling/line_pattern.h"
#include "worker/engine/visibility/resolver.h"
#include "worker/engine/visibility/time_samples.h"

namespace shutterline::engine {

/// What the slice resolver computes, the plain way: one line after the other, one segment after the other, in
/// double precision, sorted by their starts. An oracle for the one that is built of vectors: they share
/// nothing but the lines, the instants and the rule for f = 0.
class ScalarResolver final : public Resolver {
 public:
  explicit ScalarResolver(const RenderSettings& settings);

  void Resolve(const TileInput& tile, PairWeights& weights, ColorFilm* flat,
               RenderStats& stats) const override;

 private:
  const LinePattern& pattern_;
  TimeSamples time_samples_;
};

}  // namespace shutterline::engine
