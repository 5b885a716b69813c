#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <vector>

#include "worker/engine/scene/gltf_document.h"

namespace shutterline::engine {

/// Checks every buffer view against its buffer and every accessor, sparse parts included, against its
/// views; afterwards the readers below cannot leave the buffers. Reads no element.
absl::Status CheckGltfAccessors(const GltfDocument& document);

/// Components of an element: 1 for SCALAR, 3 for VEC3, 16 for MAT4.
int GltfComponents(const tinygltf::Accessor& accessor);

/// "accessor 7 (POSITION)".
std::string GltfAccessorElement(int accessor, absl::string_view role);

/// What readers ask of an accessor before they read it.
struct GltfAccessorNeed {
  absl::string_view role;                 ///< For messages: "POSITION".
  std::vector<int> types;                 ///< TINYGLTF_TYPE_...
  std::vector<int> component_types = {};  ///< Empty: any.
};

/// INVALID_ARGUMENT where the accessor is of another type.
absl::Status CheckGltfAccessorType(const GltfDocument& document, int accessor, const GltfAccessorNeed& need);

/// Decodes all elements to `out`, which has room for count × components floats. Normalized integers become
/// [0, 1] or [-1, 1], others keep their value; sparse elements replace those below. An accessor without a
/// buffer view is zeros. Equal bytes give equal floats. INVALID_ARGUMENT where sparse indices do not
/// increase strictly or exceed the count.
absl::Status ReadGltfFloats(const GltfDocument& document, int accessor, float* out);

/// The same for unsigned integer components, without normalisation.
absl::Status ReadGltfUints(const GltfDocument& document, int accessor, uint32_t* out);

}  // namespace shutterline::engine
