#pragma once

#include <compare>
#include <cstdint>

#include "worker/engine/shading/barycentric.h"

namespace shutterline::engine {

/// Different for different texels of different triangles.
struct TexelKey {
  uint64_t low = 0;
  uint32_t high = 0;  ///< 31 bits.

  friend auto operator<=>(const TexelKey&, const TexelKey&) = default;
};

/// A cell of a triangle's barycentric square [0, 1]², cut into 2^level1 columns of b1 and 2^level2 rows of
/// b2: a pyramid over the triangle whose top is one texel for all of it [gribel2011, appendix B, with levels
/// of their own for the two directions, so that texels of slivers are not slivers].
struct Texel {
  int level1 = 0, level2 = 0;
  uint32_t i = 0, j = 0;  ///< Column and row.

  friend bool operator==(const Texel&, const Texel&) = default;

  /// The centroid of what of it lies in the triangle; it must reach into it.
  Barycentric Centre() const;
  /// The texel that holds this one, one level up in the directions that are not at their top.
  Texel Parent() const;
  bool IsTop() const { return level1 == 0 && level2 == 0; }
  TexelKey KeyOf(uint32_t triangle) const {
    static_assert(kMaxLevel < 32 && kMaxLevelSum == kLowBits + 31);
    const uint64_t low =
        uint64_t{triangle} << 32 | uint64_t(level1) << (5 + kLowBits) | uint64_t(level2) << kLowBits;
    return KeyWith(low, level2, i, j);
  }
  /// The key of texel (i, j), `first` being the low part of that of (0, 0) of its triangle and levels.
  static TexelKey KeyWith(uint64_t first, int level2, uint32_t i, uint32_t j) {
    const uint64_t place = uint64_t{i} << level2 | uint64_t{j};
    return {.low = first | (place & ((uint64_t{1} << kLowBits) - 1)), .high = uint32_t(place >> kLowBits)};
  }

  static constexpr int kMaxLevel = 31;              ///< Of each direction.
  static constexpr int kMaxLevelSum = 53;           ///< Of both: what a key has room for.
  static constexpr int kLowBits = 64 - 32 - 2 * 5;  ///< Of TexelKey::low, for the place.
};

struct TexelLevels {
  int level1 = 0, level2 = 0;

  friend bool operator==(const TexelLevels&, const TexelLevels&) = default;
};

/// The texel of these levels that holds a point of the triangle.
Texel TexelAt(const Barycentric& at, const TexelLevels& levels);

}  // namespace shutterline::engine
