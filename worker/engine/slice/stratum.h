#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "worker/engine/slice/moving_vertices.h"
#include "worker/engine/slice/placed_triangles.h"
#include "worker/engine/slice/tile_mesh.h"

namespace shutterline::engine {

/// The triangles that a tile may see in a part of the shutter, nearest first, and their vertices as
/// polynomials, laid out for the kernels. Made once a tile and used by all its classes of lines. Keeps its
/// memory.
class Stratum {
 public:
  /// The end of a block in the arrays of triangles and of vertices, straight and curved.
  struct Block {
    size_t triangles = 0, straight = 0, curved = 0;
    float nearest = 0;  ///< Bound on the depth of this block's triangles and all later ones.
  };

  /// Takes the mesh's triangles `indices` (nearest first) that may be met within [begin, end] of the shutter.
  void Build(const TileMesh& mesh, std::span<const uint32_t> indices, double begin, double end);

  /// Makes the polynomials those that hold at shutter time t: curves come in pieces.
  void MoveTo(double t) {
    if (t < piece_begin_ || t >= piece_end_) LoadPieces(t);
  }

  const TileMesh& mesh() const { return *mesh_; }
  bool empty() const { return triangles_.count == 0; }
  size_t blocks() const { return blocks_.size(); }
  /// `before` the first one: everything begins at 0.
  const Block& block(size_t i) const { return blocks_[i]; }
  const GroupTriangles& triangles() const { return triangles_; }
  const MovingVertices& vertices() const { return vertices_; }
  /// The stratum's number of triangle `index` of the mesh, which must be one of the stratum's.
  uint32_t NumberOf(uint32_t index) const { return number_of_[index]; }
  /// Vertex `at` of the arrays at shutter time t: X, Y, Z, W. The operations of PlaceVertices.
  std::array<double, kRasterCoordinates> HomogeneousAt(size_t at, double t) const;

 private:
  void GatherTriangles(std::span<const uint32_t> indices, double begin, double end);
  void LoadPieces(double t);

  const TileMesh* mesh_ = nullptr;
  std::vector<Block> blocks_;
  std::vector<uint32_t> straight_;   // Mesh vertices in the order of their places.
  std::vector<uint32_t> curved_;     // The same for those on curved paths.
  std::vector<int32_t> place_of_;    // By mesh vertex: its place; curved ones as -2 - number of those.
  std::vector<uint32_t> number_of_;  // By index in the mesh.
  // The curves' polynomials hold for this part of the shutter.
  double piece_begin_ = 0, piece_end_ = 0;
  GroupTriangles triangles_;
  MovingVertices vertices_;
};

}  // namespace shutterline::engine
