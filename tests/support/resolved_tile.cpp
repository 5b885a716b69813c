#include "tests/support/resolved_tile.h"

#include <numeric>
#include <vector>

#include "worker/engine/render/make_resolver.h"
#include "worker/engine/visibility/resolver.h"

namespace shutterline::engine {

ResolvedTile::ResolvedTile(const FrameScene& frame, const TileRect& rect, const RenderSettings& settings)
    : ResolvedTile(frame, rect, *MakeResolver(settings)) {}

ResolvedTile::ResolvedTile(const FrameScene& frame, const TileRect& rect, const Resolver& resolver)
    : rect_(rect) {
  std::vector<PrimitiveTraits> traits;
  for (const FramePrimitive& primitive : frame.primitives) {
    traits.push_back({.cull_back = !primitive.material->double_sided});
  }
  std::vector<uint32_t> candidates(frame.triangles.size());
  std::iota(candidates.begin(), candidates.end(), 0u);
  resolver.Resolve({frame, traits, rect, candidates}, weights_, nullptr, stats_);
}

uint64_t ResolvedTile::Weight(int x, int y, uint32_t triangle) const {
  uint64_t weight = 0;
  weights_.ForEach(int64_t{y} * rect_.width + x, [&](const PixelPair& pair) {
    if (pair.triangle == triangle) weight += pair.weight;
  });
  return weight;
}

uint64_t ResolvedTile::Covered(int x, int y) const {
  uint64_t weight = 0;
  weights_.ForEach(int64_t{y} * rect_.width + x, [&](const PixelPair& pair) { weight += pair.weight; });
  return weight;
}

RenderSettings LineSettings(PatternKind pattern, int instants) {
  RenderSettings settings;
  settings.pattern = pattern;
  settings.time_samples = instants;
  return settings;
}

}  // namespace shutterline::engine
