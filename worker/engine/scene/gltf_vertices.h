#pragma once

#include <absl/status/status.h>
#include <absl/strings/string_view.h>

#include <vector>

#include "worker/engine/scene/gltf_document.h"
#include "worker/engine/scene/scene.h"

namespace shutterline::engine {

/// Decodes the vertex attributes and morph targets of a primitive that has passed `CheckGltfPrimitive`.
/// `finite[v]` tells whether the vertex has a place: position, morph offsets and skin weights are finite
/// numbers. Other attributes that are not finite become 0 and a warning names them.
absl::Status ReadGltfVertices(GltfDocument* document, const tinygltf::Primitive& primitive,
                              absl::string_view element, MeshPrimitive* out, std::vector<bool>* finite);

/// Types, component types and equal counts of all attributes.
absl::Status CheckGltfPrimitive(const GltfDocument& document, const tinygltf::Primitive& primitive);

}  // namespace shutterline::engine
