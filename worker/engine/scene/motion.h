#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "worker/engine/scene/frame_scene.h"
#include "worker/engine/scene/mesh_pose.h"

namespace shutterline::engine {

/// What the control points of a primitive turned out to be.
struct ControlPointFacts {
  bool all_usable = true;    ///< See IsUsable.
  double motion_pixels = 0;  ///< See FramePrimitive.
};

/// Finite, and not so large that products of a few coordinates overflow (kMaxCoordinate).
bool IsUsable(const RasterPoint& p);

/// Whether a vertex has different places at the two times. Vertices that are not usable do not count.
bool AnyVertexMoves(const FrameView& view, const MeshPrimitive& primitive, const MeshPose& open,
                    const MeshPose& close);

/// Writes the control points of every vertex, `degree` + 1 each; `close` is not looked at for degree 0.
/// Vertices in front of the near plane move along straight lines in raster space, because x, y and w are
/// linear in t; so the distance of a path's ends is its length. Runs in parallel; the result does not
/// depend on how the work was split.
ControlPointFacts WriteControlPoints(const FrameView& view, const MeshPrimitive& primitive, int degree,
                                     const MeshPose& open, const MeshPose& close,
                                     std::span<RasterPoint> control_points);

/// The largest distance, in pixels, between where a vertex is at shutter time `t` and where its control
/// points put it, over the vertices of triangles for which either place is inside the frame, and which are
/// in front of the near plane in both.
double PathDeviation(const FrameScene& frame, const FramePrimitive& primitive, const MeshPose& pose,
                     double t);

}  // namespace shutterline::engine
