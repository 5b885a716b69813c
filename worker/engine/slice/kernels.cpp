#include "worker/engine/slice/kernels.h"

// For which instruction sets, cmake/Dependencies.cmake says.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "worker/engine/slice/kernels.cpp"
#include <hwy/foreach_target.h>
// The order matters: Highway's loop above includes this file once for each instruction set.
#include <hwy/highway.h>

#include "worker/engine/slice/march-inl.h"
#include "worker/engine/slice/place-inl.h"
#include "worker/engine/slice/segments-inl.h"

#if HWY_ONCE
namespace shutterline::engine {

HWY_EXPORT(PlaceVerticesKernel);
HWY_EXPORT(PlaceTrianglesKernel);
HWY_EXPORT(MakeSegmentsKernel);
HWY_EXPORT(MarchKernel);
HWY_EXPORT(TargetName);

void PlaceVertices(const MovingVertices& vertices, size_t begin, size_t end, double t, double far_depth,
                   const LineAxes& axes, PlacedVertices& placed) {
  HWY_DYNAMIC_DISPATCH(PlaceVerticesKernel)(vertices, begin, end, t, far_depth, axes, placed);
}

void PlaceTriangles(const GroupTriangles& triangles, size_t begin, size_t end, const PlacedVertices& vertices,
                    double t, const LineClass& lines, PlacedTriangles& placed) {
  std::copy(triangles.index.data() + begin, triangles.index.data() + end, placed.index.data());
  HWY_DYNAMIC_DISPATCH(PlaceTrianglesKernel)(triangles, begin, end, vertices, t, lines, placed);
}

size_t MakeSegments(const PlacedTriangles& placed, size_t first, const LineGroup& group, Stretches& stretches,
                    int64_t& made) {
  return HWY_DYNAMIC_DISPATCH(MakeSegmentsKernel)(placed, first, group, stretches, made);
}

void March(const SegmentLists& lists, const uint32_t* ids, const LineGroup& group, uint32_t active,
           VisiblePieces& pieces) {
  HWY_DYNAMIC_DISPATCH(MarchKernel)(lists, ids, group, active, pieces);
}

const char* KernelTarget() {
  return HWY_DYNAMIC_DISPATCH(TargetName)();
}

}  // namespace shutterline::engine
#endif
