#pragma once

#include "worker/engine/scene/frame_scene.h"
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

/// SurfaceAt and Reflect under sky and ambient light, without lights, head light and ambient occlusion, of
/// points on one lit primitive.
void LightSurfaces(const FrameView& view, const Lighting& lighting, const FramePrimitive& primitive,
                   const PreparedMaterial& material, SurfaceBatch& batch);

}  // namespace shutterline::engine
