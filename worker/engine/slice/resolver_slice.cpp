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
  std::unique_ptr<Workspace> work = TakeWorkspace();
  work->mesh.Build(tile, pattern_);
  work->strata.Build(work->mesh);
  work->colors.Begin(work->mesh, flat);

  const int64_t instants = work->strata.moves() ? time_samples_.InstantsFor(work->strata.motion_pixels()) : 1;
  const auto line_weight = uint64_t(instants) * uint64_t{kSubpixelsPerPixel};
  weights.Reset(tile.rect.Area(), line_weight * uint64_t(pattern_.StepsPerPixel()));
  if (flat != nullptr) flat->Reset(tile.rect.Area());
  if (!work->mesh.triangles().empty()) {
    for (const LineClass& lines : work->lines.In(pattern_, tile.rect)) {
      work->class_resolver.Resolve(work->strata, lines, instants, work->colors, weights, stats);
    }
  }
  const std::lock_guard lock(mutex_);
  free_workspaces_.push_back(std::move(work));
}

}  // namespace shutterline::engine
