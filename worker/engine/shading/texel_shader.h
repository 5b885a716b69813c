#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "common/job/render_settings.h"
#include "common/job/render_stats.h"
#include "common/math/spaces.h"
#include "worker/engine/shading/shade.h"
#include "worker/engine/shading/shading_cache.h"
#include "worker/engine/shading/texel.h"

namespace shutterline::engine {

/// Shades points of a frame's triangles, through texels and the cache where many points may share a shading:
/// where something moves, so that a place on it is seen in many pixels, and where a shading is dear because
/// of ambient occlusion. There a point's radiance is that of its texel's centre, with the footprint of a
/// pixel there at mid-shutter; elsewhere it is its own. Thread-safe.
class TexelShader {
 public:
  /// `shader` must outlive it. `cache` may be null: texels are then shaded whenever they are asked for, and
  /// pictures are the same.
  TexelShader(const Shader& shader, const RenderSettings& settings, std::shared_ptr<ShadingCache> cache);

  /// A point that is seen at shutter time t.
  Shaded Shade(uint32_t triangle, const Barycentric& at, double t, RenderStats& stats) const;

 private:
  Shaded ShadeTexel(uint32_t triangle, const Texel& texel, RenderStats& stats) const;

  const Shader& shader_;
  double rate_;
  bool propagates_;
  CachedFrame cache_;
  std::vector<bool> uses_texels_;  // By primitive.
  std::vector<bool> textured_;     // Likewise.
};

}  // namespace shutterline::engine
