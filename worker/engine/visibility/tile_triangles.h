#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/job/tile.h"
#include "worker/engine/sampling/line_pattern.h"
#include "worker/engine/scene/frame_scene.h"
#include "worker/engine/scene/primitive_traits.h"

namespace shutterline::engine {

/// A moving triangle as one tile sees it: control points relative to the tile's corner (so that a frame
/// of 16k pixels is as exact as a small one), and conservative bounds over the whole shutter.
struct TileTriangle {
  uint32_t id = 0;  ///< Index into FrameScene::triangles.
  bool moves = false;
  bool cull_back = false;     ///< Not drawn where it is seen from behind.
  bool crosses_near = false;  ///< Must be clipped at the near or the far plane at some instant.
  /// Shading varies over the triangle: the resolver must deliver where on it each pair lies.
  bool needs_position = false;
  /// Shading is kept apart for this many equal spans of the shutter, a power of two; see ShadingBins.
  uint8_t shading_bins_log2 = 0;
  /// Upper bound on depth (larger is nearer) over triangle and shutter.
  double nearest_depth = 0;
  /// It can be inside the tile only within this part of the shutter.
  double t_in = 0, t_out = 1;
  /// Estimate of the longest raster path of a vertex over the shutter, pixels.
  double motion_pixels = 0;
  std::array<RasterPoint, 3> open, close;
  /// Motion that is not one straight piece: `pieces` and `degree` as in FramePrimitive, and the curves in
  /// TileTriangles::curves, as polynomials (BezierToPower): those of piece s, corner i begin at
  /// (3 s + i) * (degree + 1). Null where the motion is straight between `open` and `close`.
  int degree = 1, pieces = 1;
  const RasterPoint* curve = nullptr;
  /// Straight pieces, a power of two, that follow the curve within kChordPixels.
  int linear_pieces = 1;
  /// Numbers of the lines of each family that it can touch, inclusive.
  std::array<int64_t, 2> first_line{}, last_line{};

  /// The vertices at shutter time t. A vertex at rest is returned bit for bit, whatever t, so that a
  /// moving triangle still shares its resting edges with its static neighbours.
  void VerticesAt(double t, RasterPoint* vertices) const {
    if (curve != nullptr) {
      const CurvePosition at = CurvePositionAt(pieces, t);
      const RasterPoint* c = curve + 3 * at.piece * (degree + 1);
      for (int i = 0; i < 3; ++i) vertices[i] = PowerPoint(c + i * (degree + 1), degree, at.u);
      return;
    }
    for (int i = 0; i < 3; ++i) vertices[i] = moves ? open[i] + t * (close[i] - open[i]) : open[i];
  }
};

/// All triangles that a tile may see, nearest first (by nearest_depth, then id).
struct TileTriangles {
  TileTriangles() = default;
  TileTriangles(TileTriangles&&) = default;
  TileTriangles& operator=(TileTriangles&&) = default;

  TileRect rect;
  double far_depth = 0;  ///< Depths below it are clipped.
  std::vector<TileTriangle> triangles;
  std::vector<RasterPoint> curves;  ///< What triangles point to; so a copy would point elsewhere.
};

/// Makes `candidates` (from the hierarchy, any order) relative to `rect` and bounds them. Triangles that
/// turn out never to be inside are left out.
void SetUpTile(const FrameScene& frame, std::span<const PrimitiveTraits> traits, const LinePattern& pattern,
               const TileRect& rect, std::span<const uint32_t> candidates, TileTriangles& tile);

}  // namespace shutterline::engine
