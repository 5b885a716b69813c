#pragma once

#include <absl/status/statusor.h>

#include <memory>
#include <span>

#include "common/job/render_settings.h"
#include "worker/engine/scene/frame_light.h"
#include "worker/engine/scene/frame_scene.h"
#include "worker/engine/shading/shadows.h"
#include "worker/engine/shading/sky_map.h"

namespace shutterline::engine {

/// What lights a frame's surfaces: what the settings choose, for this frame.
struct Lighting {
  bool head_light = false;            ///< A soft light at the camera, instead of all else.
  std::shared_ptr<const SkyMap> sky;  ///< Null: none.
  V3d ambient{0, 0, 0};               ///< Radiance from everywhere, beside the sky.
  std::span<const FrameLight> lights;
  std::shared_ptr<const Shadows> shadows;  ///< Of the lights; null: they cast none.

  bool HasSky() const { return sky != nullptr || ambient != V3d(0); }
};

/// The frame's lights are referred to: it must outlive the result. RESOURCE_EXHAUSTED where shadows do not
/// fit into memory.
absl::StatusOr<Lighting> MakeLighting(const FrameScene& frame, const RenderSettings& settings);

}  // namespace shutterline::engine
