#pragma once

#include <cstdint>
#include <vector>

#include "common/math/spaces.h"
#include "worker/engine/scene/frame_scene.h"
#include "worker/engine/scene/primitive_traits.h"

namespace shutterline::engine {

/// Barycentric coordinates of a point in a triangle's own (object-space) parametrisation: the point is
/// (1 - b1 - b2) v0 + b1 v1 + b2 v2, with b1, b2 >= 0 and b1 + b2 <= 1.
struct Barycentric {
  double b1 = 0, b2 = 0;
};

/// How large a raster pixel is on the triangle at the shading point: derivatives of the barycentric
/// coordinates with respect to raster x and y, per pixel. Selects mip levels. Zeros mean level 0.
struct Footprint {
  double db1_dx = 0, db1_dy = 0, db2_dx = 0, db2_dy = 0;
};

/// Linear radiance leaving triangle `triangle` at `at` towards the camera: base colour (factor × vertex
/// colour × texture) under a soft head light, or as it is for unlit materials, plus emission. All
/// surfaces are opaque. A function of its arguments alone, so it does not matter who evaluates it, or
/// when. Thread-safe.
V3f Shade(const FrameScene& frame, uint32_t triangle, const Barycentric& at, const Footprint& footprint);

/// True if Shade returns the same value all over every triangle of the primitive: then `at` and
/// `footprint` are never looked at and callers need not compute them.
bool IsConstantShade(const FrameScene& frame, const FramePrimitive& primitive);

/// By primitive of the frame.
std::vector<PrimitiveTraits> TraitsOf(const FrameScene& frame);

}  // namespace shutterline::engine
