#pragma once

#include <absl/status/statusor.h>

#include "common/cryptomatte/cryptomatte.h"
#include "worker/engine/scene/asset_source.h"
#include "worker/engine/scene/scene.h"

namespace shutterline::engine {

/// Names of the nodes that place a mesh, and of the materials. A node without a name has its mesh's, and what
/// has none at all is called after its index ("node_3", "material_0"; glTF's default material "default").
MatteNames MatteNamesOf(const Scene& scene);

/// The same of a file, without reading more than its JSON. Errors as ImportGltf's.
absl::StatusOr<MatteNames> ReadMatteNames(const AssetSource& source);

}  // namespace shutterline::engine
