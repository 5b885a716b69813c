#pragma once

#include <vector>

#include "tests/support/gltf_builder.h"

namespace shutterline {

/// Small valid files that between them use every part of the importer: where mutations start.
std::vector<GltfBuilder> GltfSeeds();

}  // namespace shutterline
