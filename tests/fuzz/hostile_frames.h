#pragma once

#include <cstdint>
#include <memory>

#include "common/job/tile.h"
#include "worker/engine/scene/frame_scene.h"

namespace shutterline::engine {

/// A frame and the tile of it that is to be resolved.
struct HostileFrame {
  std::shared_ptr<const FrameScene> frame;
  TileRect rect;
};

/// Moving triangles of any bits that a frame may hold: all degrees and pieces of motion, shared, repeated and
/// collinear vertices, duplicates of whole meshes, points before, on and behind the near plane, near planes
/// of any size.
HostileFrame AnyBits(uint64_t seed);

/// Triangles whose vertices lie on a lattice of 1/8 pixel at dyadic instants, each mesh at a depth of its own
/// or a copy of another: vertices and edges that lie exactly on lines, borders of pixels and each other, yet
/// every number on the way is exact in double precision.
HostileFrame OnLattice(uint64_t seed);

/// A mesh over the whole tile all through the shutter: a grid whose rim stays outside while everything within
/// goes anywhere in front of the near plane, folds included. By continuity it leaves no gap.
HostileFrame Curtain(uint64_t seed);

}  // namespace shutterline::engine
