#pragma once

#include <memory>

#include "common/job/render_settings.h"
#include "worker/engine/render/stats.h"
#include "worker/engine/sampling/line_pattern.h"
#include "worker/engine/visibility/pair_weights.h"
#include "worker/engine/visibility/tile_triangles.h"

namespace shutterline::engine {

/// Decides what a tile's lines see over the shutter: a tile's triangles in, weights per (triangle,
/// pixel) out. Implementations are rivals that judge one another in tests. Thread-safe.
class Resolver {
 public:
  virtual ~Resolver() = default;

  /// Resolves all lines of the pattern in `tile.rect`, whose sides are at most kMaxLinePixels. `weights`
  /// is reset and then holds, per pixel, what is visible; what is missing to total() is background.
  virtual void Resolve(const TileTriangles& tile, PairWeights& weights, RenderStats& stats) const = 0;
};

/// The resolver that `settings.resolver` names, for the pattern that it names.
std::unique_ptr<const Resolver> MakeResolver(const RenderSettings& settings);

}  // namespace shutterline::engine
