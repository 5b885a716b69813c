#include "worker/engine/shading/lighting.h"

#include "common/base/status_macros.h"
#include "worker/engine/shading/studio.h"

namespace shutterline::engine {

absl::StatusOr<Lighting> MakeLighting(const FrameScene& frame, const RenderSettings& settings) {
  LightingKind kind = settings.lighting;
  if (kind == LightingKind::kAuto) {
    kind = frame.lights.empty() ? LightingKind::kStudio : LightingKind::kScene;
  }
  Lighting lighting;
  lighting.ambient = {settings.ambient[0], settings.ambient[1], settings.ambient[2]};
  lighting.head_light = kind == LightingKind::kHeadlight;
  if (kind == LightingKind::kStudio) lighting.sky = Studio();
  if (kind == LightingKind::kScene && !frame.lights.empty()) {
    lighting.lights = frame.lights;
    SL_ASSIGN_OR_RETURN(lighting.shadows, Shadows::Build(frame));
  }
  return lighting;
}

}  // namespace shutterline::engine
