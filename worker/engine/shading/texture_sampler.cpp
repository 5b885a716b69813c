#include "worker/engine/shading/texture_sampler.h"

namespace shutterline::engine {

V4f SampleTexture(const MipPyramid& pyramid, const Texture& texture, V2d uv, const V2d& duv_dx,
                  const V2d& duv_dy, int most_probes) {
  TextureWalk walk;
  walk.Make(WalkedImage(pyramid, texture), uv, duv_dx, duv_dy, most_probes);
  return walk.Sample(pyramid);
}

}  // namespace shutterline::engine
