#pragma once

#include <absl/status/status.h>

#include "worker/engine/scene/gltf_document.h"
#include "worker/engine/scene/scene.h"

namespace shutterline::engine {

/// Imports skins and holds the joints of every skinned mesh against them. Call after meshes and nodes.
absl::Status ImportGltfSkins(GltfDocument* document, Scene* scene);

}  // namespace shutterline::engine
