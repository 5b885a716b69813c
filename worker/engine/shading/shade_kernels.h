#pragma once

#include <span>

#include "worker/engine/scene/frame_scene.h"
#include "worker/engine/scene/mip_pyramid.h"
#include "worker/engine/shading/batch_looks.h"
#include "worker/engine/shading/lighting.h"
#include "worker/engine/shading/prepared_material.h"
#include "worker/engine/shading/surface_batch.h"
#include "worker/engine/shading/texture_walk.h"

/// Shading of many points by vectors, with the same bits as point by point and on every instruction set. What
/// the arrays of a batch have to hold is said there.
namespace shutterline::engine {

/// PixelFootprint of each point, by `raster`.
void MeasureFootprints(SurfaceBatch& batch);

/// WalkPlan::Make of each, by `footprint` and `coordinates`.
void PlanWalks(const WalkedImage& image, int most_probes, SurfaceBatch& batch);

/// TextureWalk::Follow: where the walks of each look at the pyramid of such an image.
void PlaceLooks(const WalkedImage& image, const SurfaceBatch& batch, BatchWalks& walks);

/// A texture that is looked at.
struct LookedAt {
  const MipPyramid* pyramid = nullptr;
  size_t slot = 0;  ///< TextureSlot.
};

/// TextureWalk::Sample of textures for which these are the walks, to the batch's `texels`.
void SumLooks(std::span<const LookedAt> textures, const BatchWalks& walks, SurfaceBatch& batch);

/// SurfaceAt and Reflect under sky and ambient light, without lights, head light and ambient occlusion, of
/// points on one lit primitive.
void LightSurfaces(const FrameView& view, const Lighting& lighting, const FramePrimitive& primitive,
                   const PreparedMaterial& material, SurfaceBatch& batch);

}  // namespace shutterline::engine
