#pragma once

#include <string>

#include "worker/engine/scene/scene.h"

namespace shutterline::engine {

/// The first promise of scene.h that a scene breaks (indices in range, arrays of their length, numbers
/// finite), or an empty string.
std::string BrokenSceneInvariant(const Scene& scene);

}  // namespace shutterline::engine
