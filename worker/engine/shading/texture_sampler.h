#pragma once

#include "common/math/spaces.h"
#include "worker/engine/scene/mip_pyramid.h"
#include "worker/engine/scene/scene.h"

namespace shutterline::engine {

/// Linear colour of a texture at `uv` (glTF: (0, 0) is the top left corner of the image, (1, 1) the bottom
/// right one), trilinearly filtered: the mip level is log2 of the longer of the two footprint axes
/// `duv_dx`, `duv_dy` (change of uv per raster pixel), counted in texels. Where a pixel is not larger than
/// a texel: bilinear, or the nearest texel if the texture says so. Coordinates that are not finite count
/// as 0.
V3f SampleTexture(const MipPyramid& pyramid, const Texture& texture, V2d uv, const V2d& duv_dx,
                  const V2d& duv_dy);

/// The texel index that `index` means in an image of `size` texels.
int WrapTexel(int64_t index, int size, WrapMode mode);

}  // namespace shutterline::engine
