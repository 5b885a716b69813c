#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>

#include "common/math/spaces.h"
#include "worker/engine/scene/mip_pyramid.h"
#include "worker/engine/scene/scene.h"
#include "worker/engine/scene/texel_quad.h"

namespace shutterline::engine {

inline constexpr int kMostProbes = 16;

/// What a walk over a footprint depends on beside the footprint: pyramids for which it is equal are looked
/// at in the same places.
struct WalkedImage {
  int width = 0, height = 0;  ///< Of level 0.
  WrapMode wrap_s = WrapMode::kRepeat, wrap_t = WrapMode::kRepeat;
  bool nearest = false;

  WalkedImage() = default;
  WalkedImage(const MipPyramid& pyramid, const Texture& texture)
      : width(pyramid.Width(0)),
        height(pyramid.Height(0)),
        wrap_s(texture.wrap_s),
        wrap_t(texture.wrap_t),
        nearest(texture.nearest) {}

  /// The number of the level of one texel.
  int LastLevel() const { return int(std::bit_width(unsigned(std::max(width, height)))) - 1; }

  friend bool operator==(const WalkedImage&, const WalkedImage&) = default;
};

/// What a walk over a footprint looks at: so many places, one step after another, at one level of a pyramid
/// or at two.
struct WalkPlan {
  /// Of places; 0: the footprint is within a texel, and the one place is seen at level 0 as the sampler says.
  int probes = 0;
  int level = 0;
  float between = 0;  ///< How far from that level to the next one.
  V2d uv{0, 0};       ///< The middle of the footprint.
  V2d step{0, 0};     ///< From place to place.

  /// Arguments as those of SampleTexture.
  static WalkPlan Make(const WalkedImage& image, V2d uv, const V2d& duv_dx, const V2d& duv_dy,
                       int most_probes);
};

/// Where a texture is looked at under a pixel: so many bilinear looks at one level of its pyramid, or at two
/// between which it is mixed. Made once for all textures of a point that agree on their WalkedImage.
class TextureWalk {
 public:
  /// Nothing is known of it until it is Made.
  TextureWalk() {}  // NOLINT: half a kilobyte that most points need a part of.

  /// Arguments as those of SampleTexture.
  void Make(const WalkedImage& image, const V2d& uv, const V2d& duv_dx, const V2d& duv_dy, int most_probes) {
    Follow(image, WalkPlan::Make(image, uv, duv_dx, duv_dy, most_probes));
  }
  void Follow(const WalkedImage& image, const WalkPlan& plan);

  /// What is seen of a pyramid of that image.
  V4f Sample(const MipPyramid& pyramid) const;
  /// Has memory send what Sample will want.
  void Prefetch(const MipPyramid& pyramid) const;

 private:
  void LookOnce(const WalkedImage& image, const V2d& uv);

  int probes_, level_;
  float between_;  ///< How far from level_ to the next one.
  std::array<TexelQuad, kMostProbes> fine_, coarse_;
};

/// The texel index that `index` means in an image of `size` texels.
int WrapTexel(int64_t index, int size, WrapMode mode);

}  // namespace shutterline::engine
