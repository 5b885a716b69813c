#pragma once

#include <string>

#include "tests/scenes/glb_scene.h"

namespace shutterline::scenes {

/// The bytes of a GLB file (glTF 2.0, one buffer in the file). Nodes that are nobody's children are the
/// roots of its scene. Equal scenes give equal bytes. Indices out of range are our own defect: SL_CHECK.
std::string EncodeGlb(const GlbScene& scene);

}  // namespace shutterline::scenes
