#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/math/spaces.h"
#include "worker/engine/sampling/line_pattern.h"
#include "worker/engine/slice/tile_vertex.h"
#include "worker/engine/visibility/layers.h"
#include "worker/engine/visibility/resolver.h"

namespace shutterline::engine {

struct TileMeshTriangle {
  uint32_t id = 0;  ///< In the frame.
  std::array<uint32_t, 3> vertices{};
  bool moves = false, cull_back = false, needs_position = false;
  /// It lets light through; see PrimitiveTraits.
  bool layer = false;
  float layer_alpha = 1, alpha_cutoff = 0;
  uint8_t shading_bins_log2 = 0;
  float nearest = 0;  ///< Bound on depth over the shutter, rounded up.
  float motion_pixels = 0;
  /// It can be inside the tile only within this part of the shutter.
  double t_in = 0, t_out = 1;
  /// Bounds of minor − slope · major by family, pixels, widened by a slack.
  std::array<double, 2> row_low{}, row_high{};
};

/// The triangles that a tile may see, nearest first (by bound on depth, then id), and their vertices, each
/// once. Keeps its memory from tile to tile.
class TileMesh {
 public:
  void Build(const TileInput& input, const LinePattern& pattern);

  const FrameScene& frame() const { return *frame_; }
  const TileRect& rect() const { return rect_; }
  double far_depth() const { return far_depth_; }
  const std::vector<TileVertex>& vertices() const { return vertices_; }
  const std::vector<TileMeshTriangle>& triangles() const { return triangles_; }
  /// Is any of them a layer?
  bool has_layers() const { return has_layers_; }

  /// By triangle: its number in the frame.
  const std::vector<uint32_t>& ids() const { return ids_; }

  /// Coefficients in the time of its piece, of the piece that holds `t`, of a vertex in homogeneous tile
  /// coordinates.
  struct Power {
    std::array<RasterPoint, 4> coefficients;
    double time_scale = 1, time_offset = 0;
  };
  Power PowerAt(const TileVertex& vertex, double t) const;

 private:
  /// Where a triangle is sorted to: nearest first, then by id.
  struct Place {
    uint64_t key;
    uint32_t triangle;  ///< In `unsorted_`.
  };

  /// A vertex that a tile meets.
  struct Met {
    uint32_t vertex, primitive;
  };

  // Step by step, each in one run through memory, so that what the next elements need can be fetched ahead: a
  // frame's vertices do not fit the caches.
  void NumberVertices(std::span<const uint32_t> candidates);
  void MakeVertices(const TileVertexMaker& maker);
  void AddTriangle(uint32_t id, const std::array<uint32_t, 3>& numbers, const PrimitiveTraits& traits);
  void SortTriangles();

  const FrameScene* frame_ = nullptr;
  TileRect rect_;
  double far_depth_ = 0;
  /// By vertex of the frame: the generation, which tells whether this tile has met it, times 2^32, and its
  /// number. A frame's vertices fit, and neighbours lie close by, which makes this cheaper than hashing.
  std::vector<uint64_t> numbers_;
  uint32_t generation_ = 0;
  std::vector<Met> met_;
  std::vector<std::array<uint32_t, 3>> corners_;  ///< By candidate: vertices in the tile.
  std::vector<TileVertex> vertices_;
  std::vector<TileMeshTriangle> unsorted_, triangles_;
  bool has_layers_ = false;
  std::vector<Place> places_;
  std::vector<uint32_t> ids_;
};

}  // namespace shutterline::engine
