#pragma once

#include <memory>

#include "worker/engine/shading/sky_map.h"

namespace shutterline::engine {

/// The light of scenes that bring none: a photographer's studio, a bright ceiling over a grey floor, a large
/// soft key light to the left behind the camera, a fainter one to the right and a rim light behind. White
/// matte surfaces come out between a tenth and one, metals have something to mirror. It stands in the world,
/// y up, not at the camera. Made when first asked for.
std::shared_ptr<const SkyMap> Studio();

/// What comes from a unit direction.
V3d StudioRadiance(const V3d& direction);

}  // namespace shutterline::engine
