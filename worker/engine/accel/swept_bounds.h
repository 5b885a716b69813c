#pragma once

#include <algorithm>
#include <limits>
#include <span>

#include "common/job/tile.h"
#include "common/math/spaces.h"

namespace shutterline::engine {

/// A rectangle of the raster, pixels, rounded outwards; empty by default. Cut to ±2^30, beyond any raster.
struct SweptBounds {
  float x0 = std::numeric_limits<float>::infinity(), y0 = x0, x1 = -x0, y1 = -x0;

  bool IsEmpty() const { return x0 > x1; }
  void Extend(const SweptBounds& other) {
    x0 = std::min(x0, other.x0);
    y0 = std::min(y0, other.y0);
    x1 = std::max(x1, other.x1);
    y1 = std::max(y1, other.y1);
  }
};

/// A tile's rectangle, to be compared with many bounds: four comparisons, without a branch between them.
class TileBorders {
 public:
  explicit TileBorders(const TileRect& rect)
      : x0_(float(rect.x)),
        y0_(float(rect.y)),
        x1_(float(rect.x + rect.width)),
        y1_(float(rect.y + rect.height)) {}

  /// What only touches overlaps. Empty bounds overlap nothing.
  bool Overlap(const SweptBounds& b) const {
    return int(b.x0 <= x1_) & int(b.x1 >= x0_) & int(b.y0 <= y1_) & int(b.y1 >= y0_);
  }
  /// Empty bounds are held by any tile.
  bool Hold(const SweptBounds& b) const {
    return int(b.x0 >= x0_) & int(b.x1 <= x1_) & int(b.y0 >= y0_) & int(b.y1 <= y1_);
  }

 private:
  float x0_, y0_, x1_, y1_;
};

/// Bounds of what is visible of a hull: of the projection of its part between the near and the far plane.
/// Whatever moves on Bezier curves stays in the hull of their control points, behind the eye as well, and a
/// point of the hull in front of the near plane is a mixture of points that are and of places where segments
/// from those to the others pass the plane; all of them have w > 0, so their projections hold its projection.
/// Conservative: widened by its rounding. Points that the near plane has before it though their w is not
/// positive, which no camera makes, give bounds that hold everything.
SweptBounds BoundsInRaster(std::span<const RasterPoint> hull, double far_depth);

}  // namespace shutterline::engine
