#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/math/spaces.h"
#include "worker/engine/sampling/line_pattern.h"
#include "worker/engine/slice/vertex_numbering.h"
#include "worker/engine/visibility/resolver.h"

namespace shutterline::engine {

/// A vertex as a tile sees it: its motion relative to the tile's corner, so that a frame of 16k pixels is as
/// exact as a small one, and bounds of it.
struct TileVertex {
  uint32_t vertex = 0;     ///< In the frame.
  uint32_t primitive = 0;  ///< In the frame.
  bool moves = false;
  bool curved = false;    ///< More than a straight line in homogeneous coordinates.
  bool in_front = false;  ///< Of the near plane, all through the shutter.
  /// Control points of a straight path (equal where it rests); curved ones are fetched piece by piece.
  RasterPoint open{}, close{};
  double nearest = 0;        ///< Bound on depth.
  double motion_pixels = 0;  ///< Length of its path, cut to the tile's surroundings.
  /// Bounds of minor − slope · major by family, pixels.
  std::array<double, 2> row_low{}, row_high{};
  /// When it may be inside each plane of the tile's frustum: from in[p] to out[p].
  std::array<float, 6> in{}, out{};
};

struct TileMeshTriangle {
  uint32_t id = 0;  ///< In the frame.
  std::array<uint32_t, 3> vertices{};
  bool moves = false, cull_back = false, needs_position = false;
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
  TileVertex MakeVertex(uint32_t vertex, uint32_t primitive, const LinePattern& pattern) const;

  const FrameScene* frame_ = nullptr;
  TileRect rect_;
  double far_depth_ = 0;
  VertexNumbering numbering_;
  std::vector<TileVertex> vertices_;
  std::vector<TileMeshTriangle> triangles_;
  std::vector<uint32_t> ids_;
};

}  // namespace shutterline::engine
