#pragma once

#include <algorithm>
#include <cstdint>

#include "common/math/tolerance.h"
#include "worker/engine/sampling/line_pattern.h"
#include "worker/engine/visibility/tile_triangles.h"

namespace shutterline::engine {

/// What a triangle covers of a line sample at one instant. Positions along the line are in subpixels
/// (2^-24 px) along the major axis from the tile's corner; depth d = z/w is linear in between.
struct LineSegment {
  int32_t begin = 0, end = 0;  ///< Covers [begin, end), begin < end, cut to the line.
  uint32_t id = 0;             ///< The triangle's id: the lower one wins where depths are equal.
  uint32_t index = 0;          ///< Index of the triangle in TileTriangles.
  // The uncut segment runs from (l0, d0) to (l1, d1), l in pixels, l0 < l1.
  double l0 = 0, l1 = 0, d0 = 0, d1 = 0;
  double slope = 0;  ///< (d1 - d0) / (l1 - l0), depth per pixel.

  /// Depth at `l` pixels. Clamped to the ends' range: rounding of the ends to subpixels must not
  /// extrapolate a nearly vertical segment.
  double DepthAt(double l) const {
    const double d = d0 + slope * (l - l0);
    return std::clamp(d, std::min(d0, d1), std::max(d0, d1));
  }
};

/// Where on its triangle a segment's points lie: barycentric coordinates over w, at both ends, which
/// are affine along the line. See BarycentricAt.
struct SegmentPosition {
  double b1_over_w[2] = {0, 0}, b2_over_w[2] = {0, 0}, one_over_w[2] = {0, 0};
};

/// Barycentric coordinates, perspective-correct, at `l` pixels along a segment.
struct SegmentBarycentric {
  double b1, b2;
};
SegmentBarycentric BarycentricAt(const LineSegment& segment, const SegmentPosition& position, double l);

/// The line as the segment code sees it.
struct SegmentLine {
  bool major_is_x = true;
  double slope = 0, intercept = 0;  ///< minor = slope · major + intercept, tile coordinates.
  int32_t begin = 0, end = 0;       ///< Subpixels: the part of the line within the tile.
};

SegmentLine MakeSegmentLine(const LinePattern& pattern, const TileLine& line);

/// Intersects `triangle` (index `index` in its tile) at shutter time t with a line. Returns false where it
/// covers nothing of it; `position` may be null where the barycentric coordinates are not wanted.
///
/// The method (docs/math/line_samples.md): with f the height over the line-sample plane, g the position
/// along the line and w the homogeneous coordinate, an edge whose ends differ in the sign of f crosses
/// the line at the convex combination of its ends with weights |f|. The positive end is always taken
/// first, so two triangles that share an edge get bit-equal crossings whatever their vertex order, and
/// f = 0 counts as positive, so a vertex or an edge on the line belongs to exactly one side. Departs
/// from [gribel2011, equation 3], which divides by a difference that vanishes where an edge is parallel
/// to the plane.
bool MakeSegment(const TileTriangle& triangle, uint32_t index, double far_depth, const SegmentLine& line,
                 double t, LineSegment* segment, SegmentPosition* position);

}  // namespace shutterline::engine
