#include "worker/engine/slice/resolver_slice.h"

#include "common/base/check.h"
#include "common/math/tolerance.h"

namespace shutterline::engine {

ResolverSlice::ResolverSlice(const RenderSettings& settings)
    : pattern_(LinePattern::Get(settings.pattern)), time_samples_(settings) {}

std::unique_ptr<ResolverSlice::Workspace> ResolverSlice::TakeWorkspace() const {
  const std::lock_guard lock(mutex_);
  if (free_workspaces_.empty()) return std::make_unique<Workspace>();
  std::unique_ptr<Workspace> workspace = std::move(free_workspaces_.back());
  free_workspaces_.pop_back();
  return workspace;
}

void ResolverSlice::Resolve(const TileInput& tile, PairWeights& weights, ColorFilm* flat,
                            RenderStats& stats) const {
  SL_CHECK(tile.rect.width <= kMaxLinePixels && tile.rect.height <= kMaxLinePixels);
  const auto line_weight = uint64_t(time_samples_.WeightPerLine()) * uint64_t{kSubpixelsPerPixel};
  weights.Reset(tile.rect.Area(), line_weight * uint64_t(pattern_.StepsPerPixel()));
  if (flat != nullptr) flat->Reset(tile.rect.Area());

  std::unique_ptr<Workspace> work = TakeWorkspace();
  work->mesh.Build(tile, pattern_);
  if (!work->mesh.triangles().empty()) {
    GroupLines(pattern_, tile.rect, work->groups);
    work->sums.BeginTile(work->mesh, pattern_, weights, flat);
    for (const LineGroup& group : work->groups) {
      work->group_resolver.Resolve(work->mesh, group, time_samples_, work->sums, stats);
    }
  }
  const std::lock_guard lock(mutex_);
  free_workspaces_.push_back(std::move(work));
}

}  // namespace shutterline::engine
