#pragma once

#include <absl/status/status.h>

#include "worker/engine/scene/gltf_document.h"
#include "worker/engine/scene/scene.h"

namespace shutterline::engine {

/// Decodes all meshes of the document, those that no node uses too, into `scene->meshes` and completes
/// the counts of `document->report`. Materials are numbered as in the file; primitives without one get
/// the number after the last.
absl::Status ImportGltfMeshes(GltfDocument* document, Scene* scene);

}  // namespace shutterline::engine
