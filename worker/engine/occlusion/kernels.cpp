#include "worker/engine/occlusion/kernels.h"

// AVX-512, AVX2, and one fallback that runs anywhere: what lies between is rare today and costs a build each.
#undef HWY_DISABLED_TARGETS
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_SSE4)
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
