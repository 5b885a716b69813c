#include "worker/engine/occlusion/kernels.h"

// For which instruction sets, cmake/Dependencies.cmake says.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "worker/engine/occlusion/kernels.cpp"
#include <hwy/foreach_target.h>
// The order matters: Highway's loop above includes this file once for each instruction set.
#include <hwy/highway.h>

#include "worker/engine/occlusion/walk-inl.h"

#if HWY_ONCE
namespace shutterline::engine {

HWY_EXPORT(WalkLineKernel);

void WalkLine(const OccluderTree& tree, const LineQuery& query, LineSegments& segments) {
  HWY_DYNAMIC_DISPATCH(WalkLineKernel)(tree, query, segments);
}

}  // namespace shutterline::engine
#endif
