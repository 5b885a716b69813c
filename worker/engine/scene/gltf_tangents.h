#pragma once

#include <absl/status/status.h>

#include "worker/engine/scene/gltf_document.h"
#include "worker/engine/scene/scene.h"

namespace shutterline::engine {

/// Makes tangents for the imported primitives that show a normal texture and got none from the file, and
/// drops those of primitives that show none. To be called once meshes and materials are there.
absl::Status ImportGltfTangents(GltfDocument* document, Scene* scene);

}  // namespace shutterline::engine
