#pragma once

#include <cstdint>
#include <span>

#include "common/job/tile.h"
#include "worker/engine/render/stats.h"
#include "worker/engine/sampling/pixel_filter.h"
#include "worker/engine/scene/frame_scene.h"
#include "worker/engine/scene/primitive_traits.h"
#include "worker/engine/visibility/color_film.h"
#include "worker/engine/visibility/layers.h"
#include "worker/engine/visibility/pair_weights.h"

namespace shutterline::engine {

/// What a resolver is given of a tile.
struct TileInput {
  const FrameScene& frame;
  std::span<const PrimitiveTraits> traits;  ///< By primitive of the frame.
  TileRect rect;                            ///< Sides at most kMaxLinePixels.
  std::span<const uint32_t> candidates;     ///< Triangles that the tile may see, each once, in any order.
  const AlphaSource* alpha = nullptr;       ///< Of layers; null: they are alike all over.
  /// Null: pixels see what lies within them. Otherwise `rect` is a tile grown by the filter's reach on all
  /// sides, and only pixels of the tile are wanted.
  const PixelFilter* filter = nullptr;
};

/// Decides what a tile's lines see over the shutter: a tile's triangles in, weights per (triangle,
/// pixel) out. Implementations are rivals that judge one another in tests. Thread-safe.
class Resolver {
 public:
  virtual ~Resolver() = default;

  /// Resolves all lines of the pattern in `tile.rect`. `weights` is reset and then holds, per pixel, what is
  /// visible; what is missing to total() is background.
  ///
  /// `flat`, if not null, is reset too, and a resolver may add triangles that have one colour to it instead
  /// of to `weights`: a pixel's share of the total is then in either of the two. With a filter pairs are
  /// those of the grown tile's pixels, each with what the pixels around take of it (PairWeights::SpreadOf).
  virtual void Resolve(const TileInput& tile, PairWeights& weights, ColorFilm* flat,
                       RenderStats& stats) const = 0;
};

}  // namespace shutterline::engine
