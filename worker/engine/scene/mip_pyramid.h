#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "common/math/spaces.h"
#include "worker/engine/scene/texel_quad.h"

namespace shutterline::engine {

struct TextureImage;

/// What the colours of an image stand for; its alpha is linear always.
enum class TextureEncoding : uint8_t { kSrgb, kLinear };
inline constexpr size_t kTextureEncodings = 2;

/// Texels of a level where they lie, four codes each, and what the codes mean. Alpha is linear always: its
/// code over the largest.
struct TexelCodes {
  enum class Kind : uint8_t {
    kBytes,       ///< code / 255.
    kShorts,      ///< code / 65535.
    kSrgbBytes,   ///< color[code].
    kSrgbShorts,  ///< color[code].
  };

  Kind kind = Kind::kShorts;
  const uint8_t* bytes = nullptr;    ///< Null where they are shorts.
  const uint16_t* shorts = nullptr;  ///< Null where they are bytes.
  const float* color = nullptr;      ///< Null where they are linear.

  const void* AddressOf(size_t number) const {
    return bytes != nullptr ? static_cast<const void*>(bytes + 4 * number) : shorts + 4 * number;
  }
};

/// An image at full size and at halves of it down to 1 x 1, each texel the mean of what it covers, in
/// linear light. Level 0 is read from the image itself (8 or 16 bits); the smaller levels are stored as
/// linear 16 bit integers. Sides that do not halve are rounded down, with texels weighted by area.
///
/// Colours are averaged plainly, not weighted by alpha: the channels of an image may be four quantities that
/// have nothing to do with one another, and glTF's colours are not premultiplied. So where alpha varies,
/// colours under transparent texels bleed into the smaller levels.
///
/// Immutable; keeps a reference to the image.
class MipPyramid {
 public:
  MipPyramid(const TextureImage& image, TextureEncoding encoding);

  int level_count() const { return int(levels_.size()) + 1; }
  int Width(int level) const;
  int Height(int level) const;
  TexelCodes CodesOf(int level) const {
    if (level == 0) return first_;
    return {.kind = TexelCodes::Kind::kShorts, .shorts = levels_[size_t(level) - 1].rgba.data()};
  }
  /// Linear colour and alpha of a texel, rows from the top.
  V4f Texel(int level, int x, int y) const;
  /// The sum of bilinear looks at a level.
  V4f Sum(int level, std::span<const TexelQuad> quads) const;
  /// Has memory send what Sum will want. Changes nothing but time.
  void Prefetch(int level, std::span<const TexelQuad> quads) const;

 private:
  struct Level {
    int width = 0, height = 0;
    std::vector<uint16_t> rgba;
  };
  /// Calls `use(texel, scale)`: texel(number) is a texel of the level, times scale.
  template <typename Use>
  auto WithTexels(int level, const Use& use) const;
  Level Half(int level) const;

  const TextureImage& image_;
  const TexelCodes first_;
  std::vector<Level> levels_;  ///< From level 1 on.
};

/// Linear value of an 8 bit and of a 16 bit sRGB code (IEC 61966-2-1).
float LinearFromSrgb8(uint8_t code);
float LinearFromSrgb16(uint16_t code);

/// Pyramids by encoding and image of a scene; null where one is not used.
using PyramidTable = std::array<std::vector<std::shared_ptr<const MipPyramid>>, kTextureEncodings>;

/// Makes pyramids when first asked for and keeps them, so that frames of a scene share them. Belongs to the
/// scene and dies with it. Thread-safe. A copy starts empty: it may belong to other images.
class MipPyramidCache {
 public:
  MipPyramidCache() = default;
  MipPyramidCache(const MipPyramidCache&) {}
  MipPyramidCache& operator=(const MipPyramidCache&);

  /// The pyramid of images[image], taken to be encoded so; the images must be those of the scene that owns
  /// the cache, always.
  std::shared_ptr<const MipPyramid> Get(const std::vector<TextureImage>& images, int image,
                                        TextureEncoding encoding) const;

 private:
  mutable std::mutex mutex_;
  mutable PyramidTable pyramids_;
};

}  // namespace shutterline::engine
