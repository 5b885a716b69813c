#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "common/job/render_settings.h"
#include "common/job/render_stats.h"
#include "worker/engine/scene/motion.h"
#include "worker/engine/shading/shade.h"
#include "worker/engine/shading/shading_cache.h"
#include "worker/engine/shading/texel.h"
#include "worker/engine/shading/texel_levels.h"

namespace shutterline::engine {

/// Shades points of a frame's triangles, through texels and the cache where settings ask for a shading rate,
/// or where many points may share a shading: where something moves, so that a place on it is seen in many
/// pixels. There a point's radiance is that of its texel's centre, with the footprint of a pixel there at
/// mid-shutter; elsewhere it is its own. Thread-safe.
class TexelShader {
 public:
  /// What the texels of a triangle have in common.
  struct Triangle {
    uint32_t number = 0;                 ///< In the frame.
    std::array<RasterPoint, 3> corners;  ///< At mid-shutter.
    TexelLevelsOfTriangle levels;
  };

  /// What has texels though no rate is asked for: what moves and has textures or light, or what takes long
  /// (Shader::IsDear).
  enum class Sharing { kMoving, kDear };

  /// `shader` must outlive it. `cache` may be null: texels are then shaded whenever they are asked for, and
  /// pictures are the same.
  TexelShader(const Shader& shader, const RenderSettings& settings, std::shared_ptr<ShadingCache> cache,
              Sharing sharing = Sharing::kMoving);

  /// Does a triangle have texels?
  bool HasTexels(uint32_t triangle) const {
    return HasTexelsOn(shader_.frame().triangles[triangle].primitive);
  }
  /// Do those of a primitive?
  bool HasTexelsOn(uint32_t primitive) const { return has_texels_[primitive]; }
  /// Have those of a primitive textures?
  bool IsTexturedOn(uint32_t primitive) const { return textured_[primitive]; }
  /// Of a triangle that has texels.
  Triangle TriangleOf(uint32_t triangle) const;
  /// The texel around a point of it; nothing where it has none, as it is behind the camera at mid-shutter.
  std::optional<Texel> TexelOf(const Triangle& triangle, const Barycentric& at) const;
  Shaded ShadeTexel(const Triangle& triangle, const Texel& texel, const TexelKey& key,
                    RenderStats& stats) const;
  /// Where there is a cache: has memory send what ShadeTexel will look for.
  void Prefetch(const TexelKey& key) const { cache_.Prefetch(key); }
  /// A point of one that has no texels and stands still.
  Shaded ShadeStill(const SurfaceTriangle& triangle, const Barycentric& at) const;
  /// A point of it that has no texel.
  Shaded ShadePoint(const Triangle& triangle, const Barycentric& at) const;

  bool HasCache() const { return bool(cache_); }

  /// A point that is seen at shutter time t, with texels or without.
  Shaded Shade(uint32_t triangle, const Barycentric& at, double t, RenderStats& stats) const;

  /// Triangles that were looked at lately, for one thread: neighbouring pixels mostly see the same ones.
  class Lately {
   public:
    explicit Lately(const Shader& shader) : shader_(shader) {}
    const SurfaceTriangle& Of(uint32_t triangle) {
      SurfaceTriangle& place = places_[triangle % kPlaces];
      if (place.primitive == nullptr || place.number != triangle) place = shader_.TriangleOf(triangle);
      return place;
    }

   private:
    static constexpr size_t kPlaces = 32;
    const Shader& shader_;
    std::array<SurfaceTriangle, kPlaces> places_;
  };
  /// The same with their help.
  Shaded Shade(uint32_t triangle, const Barycentric& at, double t, Lately& lately, RenderStats& stats) const;

 private:
  void Propagate(uint32_t triangle, Texel texel, const Shaded& shaded) const;

  const Shader& shader_;
  double rate_;
  bool propagates_;
  CachedFrame cache_;
  std::vector<bool> has_texels_;  // By primitive.
  std::vector<bool> textured_;    // Likewise.
};

}  // namespace shutterline::engine
