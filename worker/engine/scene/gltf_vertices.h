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

/// Decodes the tangents of a primitive that has its triangles, one a corner. Those that are not finite become
/// 0, with a warning; signs become 1 or -1. Does nothing where there are none or no normals, in which case
/// glTF has tangents ignored.
absl::Status ReadGltfTangents(GltfDocument* document, const tinygltf::Primitive& primitive,
                              absl::string_view element, MeshPrimitive* out);

/// Types, component types and equal counts of all attributes.
absl::Status CheckGltfPrimitive(const GltfDocument& document, const tinygltf::Primitive& primitive);

}  // namespace shutterline::engine
