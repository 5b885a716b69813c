#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "common/math/spaces.h"
#include "worker/engine/scene/frame_scene.h"
#include "worker/engine/shading/shade.h"
#include "worker/engine/shading/texel_shader.h"

namespace shutterline::engine {

/// The radiance of hits; triangles of constant shading are shaded once, when this is made. Immutable.
class HitShader {
 public:
  HitShader(Shader shader, const RenderSettings& settings, std::shared_ptr<ShadingCache> cache);
  HitShader(const HitShader&) = delete;  // `texels_` points into it.

  /// `b1`, `b2` as Embree gives them, `t` the ray's time.
  V3f Radiance(uint32_t triangle, double b1, double b2, double t, RenderStats& stats) const;
  /// How much of what lies behind is hidden there: 1 of what is opaque.
  double Alpha(uint32_t triangle, double b1, double b2, double t) const;

  const FrameScene& frame() const { return shader_.frame(); }

 private:
  Shader shader_;
  TexelShader texels_;
  /// By primitive.
  std::vector<PrimitiveTraits> traits_;
  /// By primitive: whether one shade serves every hit of a triangle; then it is in constant_shades_.
  std::vector<bool> is_constant_;
  std::vector<V3f> constant_shades_;  ///< By triangle; empty if no primitive is constant.
};

}  // namespace shutterline::engine
