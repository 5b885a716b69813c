#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "common/math/spaces.h"

namespace shutterline::engine {

struct TextureImage;

/// An image at full size and at halves of it down to 1 x 1, each texel the mean of what it covers, in
/// linear light. Level 0 is read from the image itself (8 bits, sRGB); the smaller levels are stored as
/// linear 16 bit integers. Sides that do not halve are rounded down, with texels weighted by area.
/// Immutable; keeps a reference to the image.
class MipPyramid {
 public:
  explicit MipPyramid(const TextureImage& image);

  int level_count() const { return int(levels_.size()) + 1; }
  int Width(int level) const;
  int Height(int level) const;
  /// Linear colour of a texel, rows from the top.
  V3f Texel(int level, int x, int y) const;

 private:
  struct Level {
    int width = 0, height = 0;
    std::vector<uint16_t> rgb;
  };
  const TextureImage& image_;
  std::vector<Level> levels_;  ///< From level 1 on.
};

/// Linear value of an 8 bit sRGB code (IEC 61966-2-1).
float LinearFromSrgb8(uint8_t code);

/// The pyramids that a frame's materials use, one entry an image of the scene; null where none is used.
using TextureSet = std::vector<std::shared_ptr<const MipPyramid>>;

/// Makes pyramids when first asked for and keeps them, so that frames of a scene share them. Belongs to the
/// scene and dies with it. Thread-safe. A copy starts empty: it may belong to other images.
class MipPyramidCache {
 public:
  MipPyramidCache() = default;
  MipPyramidCache(const MipPyramidCache&) {}
  MipPyramidCache& operator=(const MipPyramidCache&);

  /// The pyramid of images[image]; the images must be those of the scene that owns the cache, always.
  std::shared_ptr<const MipPyramid> Get(const std::vector<TextureImage>& images, int image) const;

 private:
  mutable std::mutex mutex_;
  mutable TextureSet pyramids_;
};

}  // namespace shutterline::engine
