#pragma once

#include "worker/engine/paper/options.h"
#include "worker/engine/sampling/line_pattern.h"
#include "worker/engine/visibility/resolver.h"

namespace shutterline::engine {

/// The visibility engine of [gribel2011, sections 4 and 5, appendix A] in double precision: what a moving
/// triangle covers of a line over the shutter is approximated by planar patches in (l, t, d), and these are
/// resolved exactly. No sampling in time, hence no noise; the error is that of the patches. Where
/// nothing on a line moves there are no patches, and the answer is exact along the line. See
/// docs/math/patches.md.
class ResolverPaper final : public Resolver {
 public:
  ResolverPaper(const LinePattern& pattern, const paper::Options& options)
      : pattern_(pattern), options_(options) {}

  void Resolve(const TileInput& input, PairWeights& weights, ColorFilm* flat,
               RenderStats& stats) const override;

 private:
  const LinePattern& pattern_;
  paper::Options options_;
};

}  // namespace shutterline::engine
