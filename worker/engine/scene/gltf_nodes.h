#pragma once

#include <absl/status/status.h>

#include "worker/engine/scene/gltf_document.h"
#include "worker/engine/scene/scene.h"

namespace shutterline::engine {

/// Imports nodes and the default scene's roots. The default scene is the one that `scene` names, else the
/// first. INVALID_ARGUMENT where a node has two parents or is its own ancestor, or where the scene lists
/// a node twice or one that has a parent; RESOURCE_EXHAUSTED where the tree is deeper than the limit.
/// Call after the meshes.
absl::Status ImportGltfNodes(GltfDocument* document, Scene* scene);

}  // namespace shutterline::engine
