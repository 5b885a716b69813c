#pragma once

#include "common/math/spaces.h"
#include "worker/engine/scene/mip_pyramid.h"
#include "worker/engine/scene/scene.h"
#include "worker/engine/shading/texture_walk.h"

namespace shutterline::engine {

/// Linear colour and alpha of a texture at `uv` (glTF: (0, 0) is the top left corner of the image, (1, 1) the
/// bottom right one) under a pixel whose axes are `duv_dx` and `duv_dy` (change of uv per raster pixel):
/// trilinear filtering, along the longer axis as often as the footprint is longer than wide, up to
/// `most_probes` times; longer footprints are blurred across. Where a pixel is not larger than a texel:
/// bilinear, or the nearest texel if the texture says so. Coordinates that are not finite count as 0.
V4f SampleTexture(const MipPyramid& pyramid, const Texture& texture, V2d uv, const V2d& duv_dx,
                  const V2d& duv_dy, int most_probes = kMostProbes);

}  // namespace shutterline::engine
