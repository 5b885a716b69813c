#pragma once

#include <cstdint>
#include <memory>

#include "common/job/render_settings.h"
#include "worker/engine/render/stats.h"
#include "worker/engine/scene/frame_scene.h"
#include "worker/engine/visibility/pair_weights.h"
#include "worker/engine/visibility/resolver.h"
#include "worker/engine/visibility/tile_triangles.h"

namespace shutterline::engine {

/// What the line resolver saw in a rectangle: exact weights per (triangle, pixel), without a hierarchy
/// and without shading in between.
class ResolvedTile {
 public:
  /// Resolves `rect` of `frame` with all its triangles as candidates.
  ResolvedTile(const FrameScene& frame, const TileRect& rect, const RenderSettings& settings);
  /// The same by a resolver of the caller's.
  ResolvedTile(const FrameScene& frame, const TileRect& rect, const Resolver& resolver);

  /// The weight of a triangle in a pixel of the rectangle, of total().
  uint64_t Weight(int x, int y, uint32_t triangle) const;
  /// Weights of all triangles in a pixel.
  uint64_t Covered(int x, int y) const;
  uint64_t total() const { return weights_.total(); }

  /// The same as fractions of the pixel.
  double Coverage(int x, int y, uint32_t triangle) const {
    return double(Weight(x, y, triangle)) / double(total());
  }
  double Coverage(int x, int y) const { return double(Covered(x, y)) / double(total()); }
  double Background(int x, int y) const { return double(total() - Covered(x, y)) / double(total()); }

  const PairWeights& weights() const { return weights_; }
  const RenderStats& stats() const { return stats_; }

 private:
  TileRect rect_;
  PairWeights weights_;
  RenderStats stats_;
};

/// Settings of the line integrator with `instants` instants wherever something moves.
RenderSettings LineSettings(PatternKind pattern, int instants);

}  // namespace shutterline::engine
