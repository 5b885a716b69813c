#include "worker/engine/paper/resolver_paper.h"

#include "common/base/check.h"
#include "common/math/tolerance.h"
#include "worker/engine/paper/patch_tile.h"
#include "worker/engine/visibility/tile_triangles.h"

namespace shutterline::engine {

void ResolverPaper::Resolve(const TileInput& input, PairWeights& weights, ColorFilm* flat,
                            RenderStats& stats) const {
  SL_CHECK(input.rect.width <= kMaxLinePixels && input.rect.height <= kMaxLinePixels);
  const uint64_t line_weight = paper::PatchTile::kShutterWeight * uint64_t{kSubpixelsPerPixel};
  weights.Reset(input.rect.Area(), line_weight * uint64_t(pattern_.StepsPerPixel()));
  // Every triangle is kept apart: few fragments leave a cell, so there is nothing to save.
  if (flat != nullptr) flat->Reset(input.rect.Area());
  TileTriangles tile;
  SetUpTile(input.frame, input.traits, pattern_, input.rect, input.candidates, tile);
  paper::PatchTile(pattern_, tile, options_, weights, stats).Resolve();
}

}  // namespace shutterline::engine
