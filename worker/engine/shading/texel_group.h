#pragma once

#include <algorithm>
#include <cstdint>

#include "worker/engine/shading/texel.h"

namespace shutterline::engine {

/// Texels that are likely to be wanted together: a block of one triangle's of the same levels or, where a
/// triangle has fewer than a block, those of triangles that follow one another in their mesh, which mostly
/// are neighbours.
struct TexelGroup {
  uint64_t place = 0;     ///< Of the block, and the levels; with `triangle` it tells groups apart.
  uint32_t triangle = 0;  ///< The first one.
  uint32_t member = 0;    ///< The texel's number in its group, below 2^bits; no two have the same.

  /// Of a key that Texel::KeyOf has made, in groups of 2^bits.
  static TexelGroup Of(const TexelKey& key, int bits) {
    const uint32_t levels = uint32_t(key.low >> Texel::kLowBits) & 1023;
    const int level1 = int(levels >> 5), level2 = int(levels & 31);
    // As square as it can be.
    const int columns = std::min(level1, std::max(bits / 2, bits - level2));
    const int rows = std::min(level2, bits - columns);
    const int triangles = bits - columns - rows;

    const uint64_t place =
        uint64_t{key.high} << Texel::kLowBits | (key.low & ((uint64_t{1} << Texel::kLowBits) - 1));
    const uint64_t row = place & ((uint64_t{1} << rows) - 1);
    const uint64_t column = place >> level2 & ((uint64_t{1} << columns) - 1);
    const uint32_t triangle = uint32_t(key.low >> 32);
    const uint32_t nth = triangle & ((uint32_t{1} << triangles) - 1);
    return {.place = uint64_t{levels} << Texel::kMaxLevelSum | (place ^ row ^ column << level2),
            .triangle = triangle ^ nth,
            .member = uint32_t((nth << columns | column) << rows | row)};
  }
};

}  // namespace shutterline::engine
