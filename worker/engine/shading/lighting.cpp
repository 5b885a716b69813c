#include "worker/engine/shading/lighting.h"

#include <algorithm>

#include "common/base/status_macros.h"
#include "worker/engine/shading/studio.h"

namespace shutterline::engine {

namespace {

bool AnythingIsLit(const FrameScene& frame) {
  return std::any_of(frame.primitives.begin(), frame.primitives.end(),
                     [](const FramePrimitive& primitive) { return !primitive.material->unlit; });
}

}  // namespace

absl::StatusOr<Lighting> MakeLighting(const FrameScene& frame, const RenderSettings& settings) {
  LightingKind kind = settings.lighting;
  const std::shared_ptr<const Environment>& environment = frame.scene->environment;
  if (kind == LightingKind::kAuto) {
    const bool has_light = environment != nullptr || !frame.lights.empty();
    kind = has_light ? LightingKind::kScene : LightingKind::kStudio;
  }
  Lighting lighting;
  lighting.ambient = {settings.ambient[0], settings.ambient[1], settings.ambient[2]};
  lighting.head_light = kind == LightingKind::kHeadlight;
  if (kind == LightingKind::kStudio && AnythingIsLit(frame)) lighting.sky = Studio();
  if (kind == LightingKind::kScene && environment != nullptr) lighting.sky = SkyMap::Of(environment);
  if (kind == LightingKind::kScene && !frame.lights.empty()) {
    lighting.lights = frame.lights;
    SL_ASSIGN_OR_RETURN(lighting.shadows, Shadows::Build(frame));
  }
  return lighting;
}

}  // namespace shutterline::engine
