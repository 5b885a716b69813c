#pragma once

#include "common/math/spaces.h"
#include "worker/engine/shading/surface.h"

namespace shutterline::engine {

/// The base colour under a soft light at the camera: `--lighting headlight`. Cheap, and the same wherever a
/// scene's lights are; metals and roughness do not show.
inline V3d ReflectHeadLight(const Surface& surface) {
  /// So much from everywhere, the rest by the cosine to the camera.
  constexpr double kEverywhere = 0.15;
  const double cosine = std::abs(surface.normal.dot(surface.to_camera));
  return (kEverywhere + (1 - kEverywhere) * cosine) * surface.base_color;
}

}  // namespace shutterline::engine
