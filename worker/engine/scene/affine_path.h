#pragma once

#include <span>

#include "worker/engine/scene/frame_scene.h"

namespace shutterline::engine {

/// A bound for many vertices at once. Vertices that one matrix places, `path` at the time that is looked at
/// and `knots` (view from object) at equal intervals of a piece of motion, lie in the object-space `box`.
/// Their places, and so what is interpolated between these, are linear in the vertices; so is the difference
/// of the curves of degree knots.size() - 1 at u and the path.
///
/// True only if PathErrorBetween is within tolerance for every vertex in the box, rounding included; false
/// where that is not so or is not seen by looking at the box alone, as where a part of it is behind the near
/// plane.
bool AffinePathIsFollowed(const FrameView& view, const Box3d& box, std::span<const M44d* const> knots,
                          double u, const M44d& path);

}  // namespace shutterline::engine
