#pragma once

#include <array>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "common/math/spaces.h"
#include "worker/engine/scene/environment.h"
#include "worker/engine/shading/lat_long_map.h"

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

  /// Real spherical harmonics up to the second degree, of a unit direction.
  static std::array<double, 9> Harmonics(const V3d& d) {
    return {kHarmonics[0],
            kHarmonics[1] * d.y,
            kHarmonics[1] * d.z,
            kHarmonics[1] * d.x,
            kHarmonics[2] * d.x * d.y,
            kHarmonics[2] * d.y * d.z,
            kHarmonics[3] * (3 * d.z * d.z - 1),
            kHarmonics[2] * d.x * d.z,
            kHarmonics[4] * (d.x * d.x - d.y * d.y)};
  }
  static constexpr double kHarmonics[] = {0.28209479177387814, 0.4886025119029199, 1.0925484305920792,
                                          0.31539156525252005, 0.5462742152960396};

  /// Irradiance over π on a surface with this normal: the radiance that a white matte surface shows.
  V3d Diffuse(const V3d& normal) const;

  /// The mean radiance around `direction` under the lobe of `roughness` in [0, 1].
  V3d Glossy(const V3d& direction, double roughness) const;

  bool is_uniform() const { return maps_.empty(); }

  // What vectors look up by themselves.

  /// A map of what surfaces mirror, see LatLongMap.
  struct Map {
    int width = 0, height = 0;
    double roughness = 0;
    size_t first = 0;  ///< The number of its first texel.
  };
  /// By roughness: the first is 0, the last 1. None where the sky is uniform.
  std::span<const Map> maps() const { return maps_; }
  /// Of all maps, and one more, so that each can be read as four floats.
  std::span<const V3f> texels() const { return texels_; }
  /// What Diffuse weights harmonics by, see Harmonics; means nothing where the sky is uniform.
  const std::array<V3d, 9>& harmonics() const { return harmonics_; }
  const V3d& uniform() const { return uniform_; }

 private:
  SkyMap() = default;
  void ProjectToHarmonics(const LatLongMap& sharp);
  void Append(LatLongMap map, double roughness);
  V3d SampleAt(const Map& map, const V2d& angles) const {
    return SampleLatLong(texels_.data() + map.first, map.width, map.height, angles);
  }

  V3d uniform_{0, 0, 0};
  std::array<V3d, 9> harmonics_{};
  std::vector<Map> maps_;
  std::vector<V3f> texels_;
};

}  // namespace shutterline::engine
