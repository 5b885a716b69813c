#pragma once

#include <optional>

#include "common/math/spaces.h"
#include "worker/engine/scene/frame_light.h"

namespace shutterline::engine {

/// What one light of KHR_lights_punctual sends to a point.
struct Incidence {
  V3d to_light;         ///< Unit.
  double distance = 0;  ///< Infinite for directional lights.
  V3d irradiance;       ///< On a surface that faces the light.
};

/// Nothing where the point is out of range, out of the cone, or in the light itself.
std::optional<Incidence> IncidenceAt(const FrameLight& light, const V3d& position);

}  // namespace shutterline::engine
