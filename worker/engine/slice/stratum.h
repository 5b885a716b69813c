#pragma once

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

  /// Places everything at shutter time t, which lies within the stratum; instants come in ascending order.
  void Place(double t);

  const GroupTriangles& triangles() const { return triangles_; }
  const PlacedTriangles& placed() const { return placed_; }
  /// What is left, at this instant, of triangles that cross the near or the far plane; in front of all others.
  const GroupTriangles& clipped_triangles() const { return clipped_; }
  const PlacedTriangles& clipped_placed() const { return clipped_placed_; }

  /// Where on triangle `index` of the mesh, one of the stratum's, the points of a lane lie at this instant.
  LinePosition PositionOn(uint32_t index, int lane) const;

 private:
  void LoadVertex(size_t at, const TileVertex& vertex, double t, bool curved);
  void LoadPieces(double t);
  void ClipTriangles(double t);

  const TileMesh* mesh_ = nullptr;
  const LineGroup* group_ = nullptr;
  int32_t length_ = 0;  // Of the lines, subpixels.

  VertexNumbering numbering_;
  std::vector<uint32_t> mesh_vertex_;  // By number within the stratum.
  std::vector<int32_t> slot_;          // By number within the stratum: place in the arrays.
  std::vector<uint32_t> curved_;       // Mesh vertices on curved paths, in the order of their slots.
  double next_piece_at_ = 0;           // From there on, curved vertices must be loaded anew.
  std::vector<uint32_t> triangle_of_;  // By index in the mesh; valid for those in the stratum.

  MovingVertices vertices_;
  PlacedVertices placed_vertices_;
  GroupTriangles triangles_;
  PlacedTriangles placed_;
  GroupTriangles clipped_;
  PlacedTriangles clipped_placed_;
};

}  // namespace shutterline::engine
