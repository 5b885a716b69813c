#pragma once

#include "worker/engine/stochastic/cell.h"

namespace shutterline::engine {

/// The shape of passes that should take the least time for a cell's triangles at `spp` samples a pixel.
PassShape ChoosePassShape(const CellTriangles& cell, int spp);

}  // namespace shutterline::engine
