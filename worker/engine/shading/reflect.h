#pragma once

#include "common/math/spaces.h"
#include "worker/engine/scene/frame_scene.h"
#include "worker/engine/shading/lighting.h"
#include "worker/engine/shading/surface.h"

namespace shutterline::engine {

/// Radiance that a surface sends to the camera of what lights it, without what it emits: a matte part and a
/// microfacet part, as glTF's metallic-roughness model has them, with the light that facets pass on to one
/// another [kulla2017, fdez2019]. What is not mirrored is scattered or absorbed, so nothing reflects more
/// than it receives, and what is white sends back all that comes from an even sky.
V3d Reflect(const FrameView& view, const Lighting& lighting, const Surface& surface);

}  // namespace shutterline::engine
