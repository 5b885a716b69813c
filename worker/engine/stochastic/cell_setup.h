#pragma once

#include <cstdint>
#include <span>

#include "common/job/tile.h"
#include "worker/engine/scene/frame_scene.h"
#include "worker/engine/scene/primitive_traits.h"
#include "worker/engine/stochastic/cell.h"

namespace shutterline::engine {

/// Makes `candidates` (any order) relative to the cell whose corner is (x, y), in double precision, and
/// sorts them nearest first.
void SetUpCell(const FrameScene& frame, std::span<const PrimitiveTraits> traits, int x, int y,
               std::span<const uint32_t> candidates, CellTriangles& cell);

}  // namespace shutterline::engine
