#pragma once

#include <array>

#include "common/math/spaces.h"
#include "worker/engine/scene/frame_scene.h"
#include "worker/engine/shading/barycentric.h"

namespace shutterline::engine {

/// The corners of a triangle of the frame at shutter time t, in homogeneous raster space.
std::array<RasterPoint, 3> CornersAt(const FrameScene& frame, uint32_t triangle, double t);

/// How barycentric coordinates change from pixel to pixel at a point of a projected triangle, `vertices`
/// in homogeneous raster space: the inverse of the Jacobian of raster position with respect to (b1, b2).
/// Zeros where the triangle is seen edge-on, so that it has no such inverse, or the point is not in
/// front of the camera.
Footprint PixelFootprint(const std::array<RasterPoint, 3>& vertices, const Barycentric& at);

/// Of a triangle of the frame at shutter time t.
Footprint PixelFootprintAt(const FrameScene& frame, uint32_t triangle, const Barycentric& at, double t);

}  // namespace shutterline::engine
