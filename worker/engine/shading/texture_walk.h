#pragma once

#include <array>
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

  friend bool operator==(const WalkedImage&, const WalkedImage&) = default;
};

/// Where a texture is looked at under a pixel: so many bilinear looks at one level of its pyramid, or at two
/// between which it is mixed. Made once for all textures of a point that agree on their WalkedImage.
class TextureWalk {
 public:
  /// Nothing is known of it until it is Made.
  TextureWalk() {}  // NOLINT: half a kilobyte that most points need a part of.

  /// Arguments as those of SampleTexture.
  void Make(const WalkedImage& image, V2d uv, const V2d& duv_dx, const V2d& duv_dy, int most_probes);

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
