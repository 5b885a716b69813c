#pragma once

#include <cstddef>
#include <vector>

#include "common/math/spaces.h"

namespace shutterline::engine {

/// Longitude and latitude of a direction as parts of a map's width and height, the former in [0, 1).
V2d LatLongOf(const V3d& direction);

/// Bilinear, of a map of so many texels; behind the last one three more bytes than it has must be readable.
/// The longitude in [-1/2, 2).
V3d SampleLatLong(const V3f* texels, int width, int height, const V2d& angles);

/// Radiance by direction, equally spaced: latitude by longitude, rows from the top (+y), x from −z around by
/// +x. World directions, y up.
struct LatLongMap {
  int width = 0, height = 0;
  std::vector<V3f> texels;  ///< And one more, so that each can be read as four floats.

  /// Black, half as high as wide.
  static LatLongMap OfSize(int width);
  /// Of half the size.
  static LatLongMap Halved(const LatLongMap& fine);

  size_t IndexOf(int x, int y) const { return size_t(y) * size_t(width) + size_t(x); }
  const V3f& At(int x, int y) const { return texels[IndexOf(x, y)]; }
  V3d Sample(const V3d& direction) const { return SampleAt(LatLongOf(direction)); }
  V3d SampleAt(const V2d& angles) const { return SampleLatLong(texels.data(), width, height, angles); }
  /// Of a texel's middle.
  V3d DirectionOf(int x, int y) const;
};

}  // namespace shutterline::engine
