#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "worker/engine/slice/line_class.h"
#include "worker/engine/slice/moving_vertices.h"
#include "worker/engine/slice/placed_triangles.h"
#include "worker/engine/slice/segment_lists.h"

/// The resolver's inner loops, compiled for several instruction sets and chosen at run time. All of them
/// give the same bits on every one: the same operations in the same order, no fused multiply-add (which the
/// oldest lacks), no sum across lanes.
namespace shutterline::engine {

/// Places vertices [begin, end) of the arrays, `begin` a multiple of kPad, at shutter time t, in the
/// coordinates of `axes`; up to kPad after them are overwritten.
void PlaceVertices(const MovingVertices& vertices, size_t begin, size_t end, double t, double far_depth,
                   const LineAxes& axes, PlacedVertices& placed);

/// Sets up triangles [begin, end) at shutter time t, at most PlacedTriangles::kMost, `begin` a multiple of
/// kPad: which of the class's lines each meets within its length, and its edges. Replaces `placed`.
void PlaceTriangles(const GroupTriangles& triangles, size_t begin, size_t end, const PlacedVertices& vertices,
                    double t, const LineClass& lines, PlacedTriangles& placed);

/// How the lines are cut into stretches that are resolved apart.
struct Stretches {
  std::span<SegmentLists> lists;
  int shift = 0;  ///< Stretch of subpixel x: x >> shift.
  std::span<const HiddenBelow> hidden_below;
};

/// Cuts the met triangles, from number `first` of them on, by the group's lines and appends the segments. A
/// crossing of an edge is computed from the edge's corners alone, in an order that does not depend on the
/// triangle, so neighbours get bit-equal ends. Returns the number at which it stopped, because a list is to
/// be compacted first; placed.met_count if it is through. Adds to `made`.
size_t MakeSegments(const PlacedTriangles& placed, size_t first, const LineGroup& group, Stretches& stretches,
                    int64_t& made);

/// Exact visibility along all lanes of a stretch in lockstep: the upper envelope of each lane's segments.
/// See docs/math/line_samples.md. `active` has a bit for each lane that is wanted;
/// `ids` are the frame's numbers of the tile's triangles: of two at equal depth the lower hides the other.
void March(const SegmentLists& lists, const uint32_t* ids, const LineGroup& group, uint32_t active,
           VisiblePieces& pieces);

/// The name of the instruction set that is used.
const char* KernelTarget();

}  // namespace shutterline::engine
