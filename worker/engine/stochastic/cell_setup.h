#pragma once

#include <cstdint>
#include <span>

#include "common/job/tile.h"
#include "worker/engine/scene/frame_scene.h"
#include "worker/engine/stochastic/cell.h"

namespace shutterline::engine {

/// What of a primitive the rasterizer must know, made once a frame.
struct StochasticTraits {
  bool cull_back = false;
  bool needs_position = false;
  bool textured = false;
};

/// Makes `candidates` (any order) relative to the cell whose corner is (x, y), in double precision, and
/// sorts them nearest first.
void SetUpCell(const FrameScene& frame, std::span<const StochasticTraits> traits, int x, int y,
               std::span<const uint32_t> candidates, CellTriangles& cell);

}  // namespace shutterline::engine
