#pragma once

#include <absl/status/status.h>

#include "worker/engine/scene/gltf_document.h"
#include "worker/engine/scene/scene.h"

namespace shutterline::engine {

/// Imports all cameras. INVALID_ARGUMENT where one cannot make a picture.
absl::Status ImportGltfCameras(GltfDocument* document, Scene* scene);

}  // namespace shutterline::engine
