#pragma once

#include <string>
#include <vector>

#include "common/math/spaces.h"
#include "worker/engine/scene/scene.h"
#include "worker/engine/scene/shutter_poses.h"

namespace shutterline::engine {

/// A light as a node of the default scene places it, in view space. Lights stand still for a frame, as they
/// are at mid-shutter.
struct FrameLight {
  PunctualLight::Kind kind = PunctualLight::Kind::kPoint;
  V3d position{0, 0, 0};    ///< Metres; means nothing for directional lights.
  V3d direction{0, 0, -1};  ///< Unit, the way the light travels; means nothing for point lights.
  V3f intensity{1, 1, 1};   ///< Colour times intensity: lux for directional lights, else candela.
  double range = 0;         ///< Metres at which the light has faded out; 0: infinite.
  /// Spot: full light within the first cone, none beyond the second. They may be equal.
  double cos_inner = 1, cos_outer = 0;
};

/// The lights of the default scene, in the order of its nodes. Scale changes neither range nor intensity.
/// A light whose node gives it no place or no direction is left out, with a warning.
std::vector<FrameLight> PlaceLights(const Scene& scene, const Moment& moment,
                                    std::vector<std::string>& warnings);

}  // namespace shutterline::engine
