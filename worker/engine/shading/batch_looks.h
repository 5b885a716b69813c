#pragma once

#include <array>
#include <cstdint>

#include "worker/engine/shading/surface_batch.h"
#include "worker/engine/shading/texture_walk.h"

namespace shutterline::engine {

/// One bilinear look at a pyramid of each point of a batch, as TexelQuad.
struct BatchLook {
  alignas(64) SurfaceBatch::Array<int32_t> top_left, top_right, bottom_left, bottom_right;
  alignas(64) SurfaceBatch::Array<float> right, down;
};

/// What the walks of a batch look at: a level, and the next one where it lies in between. By number of the
/// look along the footprint; a point makes as many as it has probes, and at least one.
struct BatchWalks {
  std::array<BatchLook, kMostProbes> fine, coarse;
};

}  // namespace shutterline::engine
