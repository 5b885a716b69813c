#pragma once

#include <cstdint>
#include <vector>

#include "common/math/spaces.h"
#include "worker/engine/scene/pose.h"
#include "worker/engine/scene/scene.h"

namespace shutterline::engine {

/// One entry a vertex: 1 where a triangle uses it.
std::vector<uint8_t> UsedVertices(const MeshPrimitive& primitive);

/// World bounds of what the nodes in `mesh_nodes` draw in `pose`; empty where that is nothing. Vertices
/// that no triangle uses, or that are not finite, do not count.
Box3d WorldBounds(const Scene& scene, const std::vector<int>& mesh_nodes, const Pose& pose);

/// World bounds of the default scene over everything that `sampler`'s channels do: at kBoundsSamples times
/// spread evenly over the keys' range, ends included. Depends on nothing else, so it is the same in every
/// frame. What stands still is evaluated once.
Box3d AnimationBounds(const PoseSampler& sampler);
inline constexpr int kBoundsSamples = 17;

}  // namespace shutterline::engine
