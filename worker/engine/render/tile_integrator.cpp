#include "worker/engine/render/tile_integrator.h"

#include "worker/engine/reference/embree_tracer.h"
#include "worker/engine/reference/instant_tracer.h"
#include "worker/engine/render/line_integrator.h"
#include "worker/engine/stochastic/stochastic_integrator.h"

namespace shutterline::engine {

absl::StatusOr<std::unique_ptr<TileIntegrator>> MakeTileIntegrator(
    std::shared_ptr<const FrameScene> frame_scene, int frame, const RenderSettings& settings, int threads) {
  switch (settings.integrator) {
    case IntegratorKind::kLine:
      return LineIntegrator::Create(std::move(frame_scene), settings, threads);
    case IntegratorKind::kReference:
      if (settings.reference_layout == ReferenceLayout::kSharedInstants &&
          InstantTracer::Fits(*frame_scene, settings.spp)) {
        return InstantTracer::Create(std::move(frame_scene), frame, settings, threads);
      }
      return EmbreeTracer::Create(std::move(frame_scene), frame, settings, threads);
    case IntegratorKind::kStochastic:
      return StochasticIntegrator::Create(std::move(frame_scene), frame, settings, threads);
  }
  return absl::InvalidArgumentError("render settings: unknown integrator");
}

}  // namespace shutterline::engine
