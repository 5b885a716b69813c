#pragma once

#include "worker/engine/occlusion/line_query.h"
#include "worker/engine/occlusion/line_segments.h"
#include "worker/engine/occlusion/occluder_tree.h"

/// The inner loop, compiled for several instruction sets and chosen at run time. All of them give the same
/// bits: the same operations in the same order, no fused multiply-add, no sum across lanes.
namespace shutterline::engine {

/// Cuts the triangles of a tree by the plane of a line and adds the sections to `segments`, which have begun
/// with the same query; from near to far, as far as boxes tell, without what is hidden by then. What is
/// added beyond that is a function of the query and the triangles alone.
void WalkLine(const OccluderTree& tree, const LineQuery& query, LineSegments& segments);

}  // namespace shutterline::engine
