#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "worker/engine/accel/view_bounds.h"
#include "worker/engine/scene/frame_scene.h"

namespace shutterline::engine {

/// A triangle over one of `spans` equal spans of the shutter, a power of two.
struct TriangleRef {
  uint32_t triangle;
  uint8_t span, spans;
};

inline constexpr int kMaxRefSpansLog2 = 4;
inline constexpr int kMaxRefSpans = 1 << kMaxRefSpansLog2;

/// Appends the points in whose hull the corners of a triangle stay during a span: control points, or those of
/// the part of a piece that the span is.
void AppendHull(const FrameScene& frame, const TriangleRef& ref, std::vector<RasterPoint>& points);

/// How finely a hierarchy should cut the motion of a triangle: 1 where it stands still, moves little, or
/// along an axis of the raster, so that its bounds over the whole shutter hold not much more than what it
/// sweeps; more, up to kMaxRefSpans, where the boxes of twice the spans together are smaller in the raster by
/// a tenth at least, each with a border added, because what counts is how many tiles they reach.
int SpansFor(const FrameScene& frame, uint32_t triangle);

/// Bounds of a reference in view space divided by `scale`, rounded outwards.
ViewBounds BoundsOf(const FrameScene& frame, const TriangleRef& ref, double scale);

/// References and their bounds by BoundsOf, one each.
struct BoundedRefs {
  std::vector<TriangleRef> refs;
  std::vector<ViewBounds> bounds;
};

/// The references of all triangles of a frame, those of a triangle in a row. Runs in parallel in the calling
/// thread's arena; the result does not depend on how.
BoundedRefs MakeBoundedRefs(const FrameScene& frame, double scale);

}  // namespace shutterline::engine
