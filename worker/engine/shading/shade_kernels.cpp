#include "worker/engine/shading/shade_kernels.h"

// As the resolver's kernels, see slice/kernels.cpp: the same bits on every instruction set.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "worker/engine/shading/shade_kernels.cpp"
#include <hwy/foreach_target.h>
// The order matters: Highway's loop above includes this file once for each instruction set.
#include <hwy/highway.h>

#include "worker/engine/shading/light_surfaces-inl.h"
#include "worker/engine/shading/place_looks-inl.h"
#include "worker/engine/shading/plan_walks-inl.h"
#include "worker/engine/shading/sum_looks-inl.h"

#if HWY_ONCE
namespace shutterline::engine {

HWY_EXPORT(MeasureFootprintsKernel);
HWY_EXPORT(PlanWalksKernel);
HWY_EXPORT(PlaceLooksKernel);
HWY_EXPORT(SumLooksKernel);
HWY_EXPORT(LightSurfacesKernel);

void MeasureFootprints(SurfaceBatch& batch) {
  HWY_DYNAMIC_DISPATCH(MeasureFootprintsKernel)(batch);
}

void PlanWalks(const WalkedImage& image, int most_probes, SurfaceBatch& batch) {
  HWY_DYNAMIC_DISPATCH(PlanWalksKernel)(image, most_probes, batch);
}

void PlaceLooks(const WalkedImage& image, const SurfaceBatch& batch, BatchWalks& walks) {
  HWY_DYNAMIC_DISPATCH(PlaceLooksKernel)(image, batch, walks);
}

void SumLooks(std::span<const LookedAt> textures, const BatchWalks& walks, SurfaceBatch& batch) {
  HWY_DYNAMIC_DISPATCH(SumLooksKernel)(textures, walks, batch);
}

void LightSurfaces(const FrameView& view, const Lighting& lighting, const FramePrimitive& primitive,
                   const PreparedMaterial& material, SurfaceBatch& batch) {
  HWY_DYNAMIC_DISPATCH(LightSurfacesKernel)(view, lighting, primitive, material, batch);
}

}  // namespace shutterline::engine
#endif
