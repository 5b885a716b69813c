#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "common/job/render_settings.h"
#include "common/job/render_stats.h"
#include "worker/engine/scene/motion.h"
#include "worker/engine/shading/shade.h"
#include "worker/engine/shading/shading_cache.h"
#include "worker/engine/shading/texel.h"

namespace shutterline::engine {

/// Shades points of a frame's triangles, through texels and the cache where settings ask for a shading rate,
/// or where many points may share a shading: where something moves, so that a place on it is seen in many
/// pixels, and where a shading is dear because of ambient occlusion. There a point's radiance is that of its
/// texel's centre, with the footprint of a pixel there at mid-shutter; elsewhere it is its own. Thread-safe.
class TexelShader {
 public:
  /// Where a triangle's corners are at mid-shutter.
  using Corners = std::array<RasterPoint, 3>;

  /// What has texels though no rate is asked for.
  enum class Sharing { kMovingAndDear, kDear };

  /// `shader` must outlive it. `cache` may be null: texels are then shaded whenever they are asked for, and
  /// pictures are the same.
  TexelShader(const Shader& shader, const RenderSettings& settings, std::shared_ptr<ShadingCache> cache,
              Sharing sharing = Sharing::kMovingAndDear);

  /// Does a triangle have texels?
  bool HasTexels(uint32_t triangle) const {
    return has_texels_[shader_.frame().triangles[triangle].primitive];
  }
  Corners CornersOf(uint32_t triangle) const;
  /// A point of a triangle that has texels.
  Shaded ShadeOnTexels(uint32_t triangle, const Corners& corners, const Barycentric& at,
                       RenderStats& stats) const;

  /// A point that is seen at shutter time t, with texels or without.
  Shaded Shade(uint32_t triangle, const Barycentric& at, double t, RenderStats& stats) const;

 private:
  Shaded ShadeTexel(uint32_t triangle, const Corners& corners, const Texel& texel, RenderStats& stats) const;
  void Propagate(uint32_t triangle, Texel texel, const Shaded& shaded) const;

  const Shader& shader_;
  double rate_;
  bool propagates_;
  CachedFrame cache_;
  std::vector<bool> has_texels_;  // By primitive.
  std::vector<bool> textured_;    // Likewise.
};

}  // namespace shutterline::engine
