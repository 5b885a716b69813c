#pragma once

#include <cstdint>
#include <optional>

#include "worker/engine/scene/frame_scene.h"

namespace shutterline::engine {

struct VisiblePoint {
  uint32_t triangle = 0;
  double b1 = 0, b2 = 0;  ///< Barycentric coordinates, as Shade takes them.
  double depth = 0;       ///< z/w: larger is nearer.
};

/// What is seen at the raster position (x, y) at shutter time t, by trying all triangles in double precision
/// with homogeneous edge functions: no clipping, no division before the hit is known, no acceleration. Near
/// and far plane, facing and ties (lowest number) as FrameScene defines them.
std::optional<VisiblePoint> SeeAt(const FrameScene& frame, double x, double y, double t);

}  // namespace shutterline::engine
