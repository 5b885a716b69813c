#pragma once

#include <absl/status/status.h>

#include "worker/engine/scene/gltf_document.h"
#include "worker/engine/scene/scene.h"

namespace shutterline::engine {

/// Imports all animations. Channels that animate what glTF does not know, or what their node does not
/// have, are left out with a warning; key times that do not increase strictly, keys that are not finite
/// and outputs of another length than the input calls for are INVALID_ARGUMENT. Rotations of length 0
/// become the identity with a warning; others stay as they are in the file, and need not be of unit
/// length. Call after meshes and nodes.
absl::Status ImportGltfAnimations(GltfDocument* document, Scene* scene);

}  // namespace shutterline::engine
