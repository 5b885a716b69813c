#pragma once

#include "worker/engine/visibility/segment.h"
#include "worker/engine/visibility/tile_triangles.h"

namespace shutterline::engine::paper {

/// Where on the triangle the point at l pixels along a line lies at shutter time t: exactly, by
/// homogeneous edge functions, not by its patch. The patch is an approximation, so the point may lie just
/// outside: coordinates are cut to the triangle.
SegmentBarycentric BarycentricOf(const TileTriangle& triangle, const SegmentLine& line, double l, double t);

}  // namespace shutterline::engine::paper
