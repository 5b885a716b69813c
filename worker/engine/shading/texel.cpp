#include "worker/engine/shading/texel.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace shutterline::engine {
namespace {

/// The column or row of a coordinate in [0, 1]; the last one's far border belongs to it.
uint32_t CellOf(double b, int level) {
  const auto cells = uint64_t{1} << level;
  return uint32_t(std::min(uint64_t(b * double(cells)), cells - 1));
}

}  // namespace

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

}  // namespace shutterline::engine
