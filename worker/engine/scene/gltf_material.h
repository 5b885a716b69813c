#pragma once

#include <absl/status/status.h>

#include "worker/engine/scene/gltf_document.h"
#include "worker/engine/scene/scene.h"

namespace shutterline::engine {

/// Imports all materials, followed by glTF's default material, and those textures and images that they name
/// (unlit ones: their base colour's alone); other images of the file are not looked at. An image that is
/// missing or cannot be decoded is an error: a frame with a white car is worse than no frame. A number out of
/// its range is moved into it, with a warning; but an emissive factor above 1 is taken at its word.
absl::Status ImportGltfMaterials(GltfDocument* document, Scene* scene);

}  // namespace shutterline::engine
