#pragma once

#include <optional>

namespace shutterline {

/// How much an occluder at distance d lets through, ρ(d) [gribel2011, equation 1], within the radius:
/// nothing, d / radius, or (d / radius)². Beyond the radius all.
enum class OcclusionFalloff { kNone, kLinear, kQuadratic };
/// Hemisphere lines all through the pole, spread by a remapping; or tilted, of uniform density.
enum class OcclusionPattern { kPole, kTilted };

/// Ambient occlusion by line samples on the hemisphere [gribel2011, section 6].
struct OcclusionSettings {
  int lines = 16;  ///< A shading point, 1 to kMaxOcclusionLines.
  /// Metres, kMinOcclusionRadius to kMaxOcclusionRadius: what is farther away does not occlude. Unset:
  /// everything occludes; `falloff` is then kNone.
  std::optional<double> radius;
  OcclusionFalloff falloff = OcclusionFalloff::kNone;
  OcclusionPattern pattern = OcclusionPattern::kPole;
  /// The mean over the shutter, of occluders as they move past the moving point; else that of mid-shutter.
  bool motion = true;

  friend bool operator==(const OcclusionSettings&, const OcclusionSettings&) = default;
};

inline constexpr int kMaxOcclusionLines = 1024;
inline constexpr double kMinOcclusionRadius = 1e-12;
inline constexpr double kMaxOcclusionRadius = 1e12;

}  // namespace shutterline
