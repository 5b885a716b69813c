#pragma once

#include <cstdint>
#include <memory>

#include "worker/engine/scene/frame_scene.h"

namespace shutterline::engine {

/// Triangles at random places of a 32x32 frame, of all sizes, some at rest, some moving, some through the
/// near plane, some of them meshes that share vertices, some coloured by vertex: whatever a resolver may
/// meet. `curved`: some move on curves.
std::shared_ptr<const FrameScene> RandomSoup(uint64_t seed, int triangles, bool curved = false);

}  // namespace shutterline::engine
