#pragma once

#include <array>
#include <cstdint>

#include "common/math/spaces.h"
#include "worker/engine/sampling/line_pattern.h"
#include "worker/engine/scene/frame_scene.h"

namespace shutterline::engine {

/// A vertex as a tile sees it: its motion relative to the tile's corner, so that a frame of 16k pixels is as
/// exact as a small one, and bounds of it.
struct TileVertex {
  /// The planes of a tile's frustum: left, right, top, bottom, near, far; and two that everything is inside
  /// of, which make them whole vectors.
  static constexpr size_t kPlanes = 8;

  uint32_t vertex = 0;     ///< In the frame.
  uint32_t primitive = 0;  ///< In the frame.
  bool moves = false;
  bool curved = false;         ///< More than a straight line in homogeneous coordinates.
  bool in_front = true;        ///< Of the near plane, all through the shutter.
  bool always_inside = false;  ///< Of all planes, all through the shutter.
  /// Control points of a straight path (equal where it rests); curved ones are fetched piece by piece.
  RasterPoint open{}, close{};
  double nearest = 0;        ///< Bound on depth.
  double motion_pixels = 0;  ///< Length of its path, cut to the tile's surroundings.
  /// Bounds of minor − slope · major by family, pixels.
  std::array<double, 2> row_low{}, row_high{};
  /// When it may be inside each plane: from in[p] to out[p], in = 1 and out = 0 for never, rounded outwards.
  std::array<float, kPlanes> in{}, out{};
};

/// Makes the vertices of one tile.
class TileVertexMaker {
 public:
  TileVertexMaker(const FrameScene& frame, const TileRect& rect, const LinePattern& pattern);

  /// `vertex` is as default-constructed.
  void Make(uint32_t primitive, uint32_t number, TileVertex& vertex) const;

  RasterPoint RelativeToTile(const RasterPoint& p) const {
    return {p.x - x_ * p.w, p.y - y_ * p.w, p.z, p.w};
  }

 private:
  using Distances = std::array<double, TileVertex::kPlanes>;
  struct Bounds;

  void PlaneDistances(const RasterPoint& p, Distances& distances) const;
  /// Extends bounds, and the path, by a control point relative to the tile. Takes it that it is in front.
  void Extend(const RasterPoint& p, bool is_first, TileVertex& vertex, Bounds& bounds) const;
  void Finish(const Bounds& bounds, TileVertex& vertex) const;
  void MakeStraight(const RasterPoint& open, const RasterPoint& close, TileVertex& vertex) const;
  void MakeCurved(const FramePrimitive& primitive, const RasterPoint* points, TileVertex& vertex) const;

  const FrameScene& frame_;
  double x_, y_, width_, height_, far_depth_;
  size_t families_;
  std::array<bool, 2> major_is_x_{};
  std::array<double, 2> slope_{};
};

}  // namespace shutterline::engine
