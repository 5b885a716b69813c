#pragma once

#include <cstdint>
#include <vector>

#include "common/math/spaces.h"

namespace shutterline::engine {

struct MeshPrimitive;
struct Mesh;

/// What fitting asks of a primitive's vertices before it looks at where they are.
struct VertexSets {
  std::vector<uint8_t> used;    ///< See UsedVertices.
  std::vector<uint32_t> tried;  ///< Some of the used ones, evenly taken; empty: there are not many, try all.
  Box3d box;                    ///< Of the used ones, object space; infinite if one is not finite.
};

VertexSets MakeVertexSets(const MeshPrimitive& primitive);

}  // namespace shutterline::engine
