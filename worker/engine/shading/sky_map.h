#pragma once

#include <array>
#include <functional>
#include <memory>
#include <vector>

#include "common/math/spaces.h"
#include "worker/engine/scene/environment.h"
#include "worker/engine/scene/float4.h"

namespace shutterline::engine {

/// Radiance that comes from everywhere, ready for shading: what surfaces turned in a direction receive, as
/// spherical harmonics up to the second degree [ramamoorthi2001], and what ever rougher ones mirror, as maps
/// filtered by GGX lobes seen head-on [karis2013]. World directions, y up, of any unit vector. Immutable.
class SkyMap {
 public:
  /// Radiance that comes from a unit direction.
  using Radiance = std::function<V3d(const V3d& direction)>;

  /// The same from everywhere.
  static std::shared_ptr<const SkyMap> Uniform(const V3d& radiance);

  /// Samples `radiance` at `width` × `width` / 2 directions, equally spaced in longitude and latitude. At
  /// least 8 wide. Deterministic.
  static std::shared_ptr<const SkyMap> Make(const Radiance& radiance, int width);

  /// Of a picture. The last one made is kept, as the frames of a scene share it. Thread-safe.
  static std::shared_ptr<const SkyMap> Of(const std::shared_ptr<const Environment>& environment);

  /// Irradiance over π on a surface with this normal: the radiance that a white matte surface shows.
  V3d Diffuse(const V3d& normal) const;

  /// The mean radiance around `direction` under the lobe of `roughness` in [0, 1].
  V3d Glossy(const V3d& direction, double roughness) const;

  bool is_uniform() const { return levels_.empty(); }

 private:
  /// Latitude by longitude, rows from the top (+y), x from −z around by +x.
  struct Level {
    /// Longitude and latitude of a direction as parts of a map's width and height, the former in [0, 1).
    static V2d AnglesOf(const V3d& direction);

    int width = 0, height = 0;
    double roughness = 0;
    std::vector<V3f> texels;  ///< And one more, so that each can be read as four floats.

    size_t IndexOf(int x, int y) const { return size_t(y) * size_t(width) + size_t(x); }
    const V3f& At(int x, int y) const { return texels[IndexOf(x, y)]; }
    /// With a fourth number that means nothing.
    Float4 Padded(int x, int y) const;
    V3d Sample(const V3d& direction) const { return At(AnglesOf(direction)); }
    V3d At(const V2d& angles) const;
    static Level OfSize(int width, double roughness);
    V3d DirectionOf(int x, int y) const;
  };

  SkyMap() = default;
  void ProjectToHarmonics(const Level& sharp);
  static Level Halved(const Level& fine);
  static Level Filtered(const std::vector<Level>& sources, int width, double roughness);

  V3d uniform_{0, 0, 0};
  std::array<V3d, 9> harmonics_;
  std::vector<Level> levels_;  ///< By roughness, the first is 0, the last 1.
};

}  // namespace shutterline::engine
