#include "worker/engine/shading/texel.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

namespace shutterline::engine {
namespace {

/// So many levels that a texel is about 1 / rate pixels wide, between 1/√2 and √2 of it, in a direction along
/// which √`squared` of the triangle's side is a pixel; -1 if there is no such level. By the exponent's bits,
/// so that it is the same on all machines.
int LevelFor(double squared, double rate) {
  const double texels = rate * rate / squared;  // Along the side, squared.
  if (!(texels <= 0x1p62) || !(texels >= 0)) return -1;
  if (texels <= 2) return 0;
  // The least level with 4^level >= texels / 2, from the bits of a number that is above 2.
  const auto bits = std::bit_cast<uint64_t>(texels);
  const int exponent = int(bits >> 52) - 1023;  // It is in [2^exponent, 2^(exponent + 1)).
  const bool is_power = (bits & ((uint64_t{1} << 52) - 1)) == 0;
  return is_power ? exponent / 2 : (exponent + 1) / 2;
}

/// The column or row of a coordinate in [0, 1]; the last one's far border belongs to it.
uint32_t CellOf(double b, int level) {
  const auto cells = uint64_t{1} << level;
  return uint32_t(std::min(uint64_t(b * double(cells)), cells - 1));
}

}  // namespace

std::optional<TexelLevels> LevelsAt(const Footprint& pixel, double rate) {
  const TexelLevels levels{LevelFor(pixel.db1_dx * pixel.db1_dx + pixel.db1_dy * pixel.db1_dy, rate),
                           LevelFor(pixel.db2_dx * pixel.db2_dx + pixel.db2_dy * pixel.db2_dy, rate)};
  const bool fits =
      levels.level1 >= 0 && levels.level2 >= 0 && levels.level1 + levels.level2 <= Texel::kMaxLevelSum;
  return fits ? std::optional(levels) : std::nullopt;
}

Texel TexelAt(const Barycentric& at, const TexelLevels& levels) {
  Texel texel{levels.level1, levels.level2, CellOf(at.b1, levels.level1), CellOf(at.b2, levels.level2)};
  // A point on the triangle's long side may round into a cell that only touches it: in units of the finest
  // cell,
  const uint64_t low = uint64_t{texel.i} << levels.level2, high = uint64_t{texel.j} << levels.level1;
  if (low + high >= uint64_t{1} << (levels.level1 + levels.level2)) {
    if (texel.i > 0) {
      --texel.i;
    } else {
      --texel.j;
    }
  }
  return texel;
}

Barycentric Texel::Centre() const {
  const double width = 1 / double(uint64_t{1} << level1), height = 1 / double(uint64_t{1} << level2);
  const double x = i * width, y = j * height;
  const double room = 1 - x - y;  // From its near corner to the long side, along b1 or along b2.
  if (width + height <= room) return {x + 0.5 * width, y + 0.5 * height};
  // The rectangle less the corner that is cut off: a triangle of legs `cut`, less what of that lies beyond
  // the rectangle's other two corners.
  const auto corner_area = [](double leg) { return 0.5 * leg * leg; };
  const double area = corner_area(room) - corner_area(std::max(room - width, 0.0)) -
                      corner_area(std::max(room - height, 0.0));
  // First moments about the near corner, of right-angled triangles with equal legs: area × leg / 3, shifted.
  const double beyond_x = std::max(room - width, 0.0), beyond_y = std::max(room - height, 0.0);
  const double moment_x = corner_area(room) * room / 3 - corner_area(beyond_x) * (width + beyond_x / 3) -
                          corner_area(beyond_y) * (beyond_y / 3);
  const double moment_y = corner_area(room) * room / 3 - corner_area(beyond_x) * (beyond_x / 3) -
                          corner_area(beyond_y) * (height + beyond_y / 3);
  const double b1 = std::clamp(x + moment_x / area, 0.0, 1.0);
  return {b1, std::clamp(y + moment_y / area, 0.0, 1 - b1)};
}

Texel Texel::Parent() const {
  return {.level1 = std::max(level1 - 1, 0),
          .level2 = std::max(level2 - 1, 0),
          .i = level1 > 0 ? i / 2 : i,
          .j = level2 > 0 ? j / 2 : j};
}

TexelKey Texel::KeyOf(uint32_t triangle) const {
  constexpr int kLowBits = 64 - 32 - 2 * 5;
  static_assert(kMaxLevel < 32 && kMaxLevelSum == kLowBits + 31);
  const uint64_t place = uint64_t{i} << level2 | uint64_t{j};
  return {.low = uint64_t{triangle} << 32 | uint64_t(level1) << (5 + kLowBits) |
                 uint64_t(level2) << kLowBits | (place & ((uint64_t{1} << kLowBits) - 1)),
          .high = uint32_t(place >> kLowBits)};
}

}  // namespace shutterline::engine
