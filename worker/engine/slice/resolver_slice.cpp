#include "worker/engine/slice/resolver_slice.h"

#include <optional>

#include "common/base/check.h"
#include "common/math/tolerance.h"
#include "worker/engine/visibility/line_spread.h"
#include "worker/engine/visibility/time_samples.h"

namespace shutterline::engine {

ResolverSlice::ResolverSlice(const RenderSettings& settings)
    : pattern_(LinePattern::Get(settings.pattern)),
      shutter_(settings.shutter_curve),
      effort_chooser_(settings) {}

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
  const Effort effort = effort_chooser_.Choose(work->strata, flat, tile.alpha, work->effort, stats);
  const auto line_weight = uint64_t(effort.instants) * uint64_t{kSubpixelsPerPixel};
  uint64_t total = line_weight * uint64_t(effort.pattern->StepsPerPixel());
  std::optional<LineSpread> spread;
  if (tile.filter != nullptr) {
    spread.emplace(*tile.filter, effort.pattern->StepsPerPixel() / 2, effort.instants);
    total = spread->PixelTotal();
  }
  const int taps = spread ? spread->taps() : 0;
  weights.Reset(tile.rect.Area(), total, taps);
  if (flat != nullptr) flat->Reset(tile.rect.Area(), taps);
  work->colors.Begin(work->mesh, flat);
  if (!work->mesh.triangles().empty()) {
    for (const LineClass& lines : work->lines.In(*effort.pattern, tile.rect)) {
      work->instants.clear();
      for (int64_t i = 0; i < effort.instants; ++i) {
        work->instants.push_back(
            shutter_.TimeOf(TimeSamples::InstantAt(i, effort.instants, lines.instant_offset)));
      }
      work->class_resolver.Resolve(work->strata, lines, work->instants, work->colors, tile.alpha,
                                   spread ? &*spread : nullptr, weights, stats);
    }
  }
  const std::lock_guard lock(mutex_);
  free_workspaces_.push_back(std::move(work));
}

}  // namespace shutterline::engine
