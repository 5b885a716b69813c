#include "worker/engine/shading/lat_long_map.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "worker/engine/scene/float4.h"
#include "worker/engine/shading/quick_angle.h"

namespace shutterline::engine {
namespace {

/// With a fourth number that means nothing.
Float4 Padded(const V3f* texels, size_t index) {
  Float4 texel;
  std::memcpy(&texel, reinterpret_cast<const char*>(texels) + sizeof(V3f) * index, sizeof(texel));
  return texel;
}

}  // namespace

V2d LatLongOf(const V3d& direction) {
  const double longitude = QuickAngle(direction.x, -direction.z) / (2 * M_PI);
  const double level = std::sqrt(direction.x * direction.x + direction.z * direction.z);
  return {longitude < 0 ? longitude + 1 : longitude, QuickAngle(level, direction.y) / M_PI};
}

V3d SampleLatLong(const V3f* texels, int width, int height, const V2d& angles) {
  // Both are at least -1/2: what is cut off is what lies above the integer.
  const double x = angles.x * width + (width - 0.5), y = angles.y * height + 0.5;
  const int column = int(x), row = int(y);
  const auto fx = float(x - column), fy = float(y - row);
  int x0 = column;
  while (x0 >= width) x0 -= width;  // Once or twice: no division is as quick.
  const int x1 = x0 + 1 < width ? x0 + 1 : 0;
  const int y0 = std::max(row - 1, 0), y1 = std::min(row, height - 1);
  const size_t upper_row = size_t(y0) * size_t(width), lower_row = size_t(y1) * size_t(width);
  const Float4 upper =
      Mix(Padded(texels, upper_row + size_t(x0)), Padded(texels, upper_row + size_t(x1)), fx);
  const Float4 lower =
      Mix(Padded(texels, lower_row + size_t(x0)), Padded(texels, lower_row + size_t(x1)), fx);
  const Float4 mixed = Mix(upper, lower, fy);
  return {mixed[0], mixed[1], mixed[2]};
}

LatLongMap LatLongMap::OfSize(int width) {
  LatLongMap map;
  map.width = width;
  map.height = width / 2;
  map.texels.assign(size_t(map.width) * size_t(map.height) + 1, V3f(0));
  return map;
}

LatLongMap LatLongMap::Halved(const LatLongMap& fine) {
  LatLongMap half = OfSize(fine.width / 2);
  for (int y = 0; y < half.height; ++y) {
    for (int x = 0; x < half.width; ++x) {
      half.texels[half.IndexOf(x, y)] = 0.25f * (fine.At(2 * x, 2 * y) + fine.At(2 * x + 1, 2 * y) +
                                                 fine.At(2 * x, 2 * y + 1) + fine.At(2 * x + 1, 2 * y + 1));
    }
  }
  return half;
}

V3d LatLongMap::DirectionOf(int x, int y) const {
  const double longitude = 2 * M_PI * (x + 0.5) / width;
  const double latitude = M_PI * (y + 0.5) / height;
  return {std::sin(latitude) * std::sin(longitude), std::cos(latitude),
          -std::sin(latitude) * std::cos(longitude)};
}

}  // namespace shutterline::engine
