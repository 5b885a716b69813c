#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "worker/engine/slice/kernels.h"
#include "worker/engine/slice/line_sums.h"
#include "worker/engine/slice/tile_mesh.h"
#include "worker/engine/slice/vertex_numbering.h"

namespace shutterline::engine {

/// The triangles that a group of lines may meet during a part of the shutter, ready to be placed at instants
/// of it: their vertices in the group's line coordinates. Keeps its memory.
class Stratum {
 public:
  /// Takes the mesh's triangles `indices` (nearest first) that may be met within [begin, end] of the shutter.
  void Build(const TileMesh& mesh, const LineGroup& group, std::span<const uint32_t> indices, double begin,
             double end);

  bool empty() const { return triangles_.count == 0; }

  /// Moves on to shutter time t, which lies within the stratum; instants come in ascending order.
  void BeginInstant(double t);

  /// The triangles are placed block by block, nearest first. False if there is no further one.
  bool PlaceNextBlock();
  /// Bound on the depth of all triangles that have not been placed yet.
  float nearest_left() const { return blocks_[next_block_].nearest; }

  const GroupTriangles& triangles() const { return triangles_; }
  /// The block placed last.
  const PlacedTriangles& placed() const { return placed_; }
  /// What is left, at this instant, of the block's triangles that cross the near or the far plane.
  const GroupTriangles& clipped_triangles() const { return clipped_; }
  const PlacedTriangles& clipped_placed() const { return clipped_placed_; }

  /// Where on triangle `index` of the mesh, one of the stratum's, the points of a lane lie at this instant.
  LinePosition PositionOn(uint32_t index, int lane);

 private:
  /// Triangles that are placed at once: some vectors' worth, and few enough that little is placed in vain.
  static constexpr size_t kBlock = 128;

  /// The end of a block in the arrays of triangles and of vertices, straight and curved.
  struct Block {
    size_t triangles = 0, straight = 0, curved = 0;
    float nearest = 0;  // Of the block's first triangle.
  };

  void LoadStraight(size_t at, const TileVertex& vertex);
  void LoadPieces();
  void ClipTriangles();
  /// A vertex at the instant, in homogeneous line coordinates.
  std::array<double, kLineCoordinates> HomogeneousAt(size_t at) const;

  const TileMesh* mesh_ = nullptr;
  const LineGroup* group_ = nullptr;
  int32_t length_ = 0;  // Of the lines, subpixels.

  double t_ = 0;
  size_t next_block_ = 0;
  std::vector<Block> blocks_;  // And one more, which ends where the last does.

  VertexNumbering numbering_;
  std::vector<int32_t> slot_;          // By number: place in the arrays; curved ones as -1 - number of those.
  std::vector<uint32_t> straight_;     // Mesh vertices in the order of their slots.
  std::vector<uint32_t> curved_;       // The same for those on curved paths.
  double next_piece_at_ = 0;           // From there on, curved vertices must be loaded anew.
  std::vector<uint32_t> triangle_of_;  // By index in the mesh; valid for those in the stratum.

  /// Positions on a triangle over the lines' plane, at the instant with number `instant`.
  struct Plane {
    int64_t instant = -1;
    bool edge_on = false;
    std::array<V3d, 3> over_w{};  // b1, b2 and their sum with b0, over w; times (row, position, 1).
  };
  std::vector<Plane> planes_;  // By triangle.
  int64_t instant_ = 0;

  MovingVertices vertices_;
  PlacedVertices placed_vertices_;
  GroupTriangles triangles_;
  PlacedTriangles placed_;
  GroupTriangles clipped_;
  PlacedTriangles clipped_placed_;
};

}  // namespace shutterline::engine
