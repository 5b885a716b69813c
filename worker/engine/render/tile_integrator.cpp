#include "worker/engine/render/tile_integrator.h"

#include <absl/strings/str_cat.h>

#include <utility>

#include "common/base/status_macros.h"
#include "worker/engine/reference/embree_tracer.h"
#include "worker/engine/reference/instant_tracer.h"
#include "worker/engine/render/line_integrator.h"
#include "worker/engine/stochastic/stochastic_integrator.h"

namespace shutterline::engine {

absl::StatusOr<std::unique_ptr<TileIntegrator>> MakeTileIntegrator(
    std::shared_ptr<const FrameScene> frame_scene, int frame, const RenderSettings& settings, int threads,
    std::shared_ptr<ShadingCache> cache) {
  SL_RETURN_IF_ERROR(ValidateFilter(settings));
  const bool is_line = settings.integrator == IntegratorKind::kLine;
  if (!is_line && !(settings.aovs.empty() && settings.mattes.empty())) {
    return absl::UnimplementedError(
        absl::StrCat("integrator ", ToString(settings.integrator), ": it makes no AOVs and no Cryptomatte"));
  }
  switch (settings.integrator) {
    case IntegratorKind::kLine:
      return LineIntegrator::Create(std::move(frame_scene), settings, std::move(cache), threads);
    case IntegratorKind::kReference:
      if (settings.reference_layout == ReferenceLayout::kSharedInstants &&
          InstantTracer::Fits(*frame_scene, settings.spp)) {
        return InstantTracer::Create(std::move(frame_scene), frame, settings, threads, std::move(cache));
      }
      return EmbreeTracer::Create(std::move(frame_scene), frame, settings, threads, std::move(cache));
    case IntegratorKind::kStochastic:
      return StochasticIntegrator::Create(std::move(frame_scene), frame, settings, threads);
  }
  return absl::InvalidArgumentError("render settings: unknown integrator");
}

}  // namespace shutterline::engine
