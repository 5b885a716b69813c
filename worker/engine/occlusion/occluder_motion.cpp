#include "worker/engine/occlusion/occluder_motion.h"

#include "common/math/bezier.h"

namespace shutterline::engine {

MovingBox OccluderMotion::Bound(uint32_t number, int span) const {
  const FrameTriangle& triangle = frame.triangles[number];
  const FramePrimitive& primitive = frame.primitives[triangle.primitive];
  MovingBox box;
  std::vector<V3d> hull;
  for (const uint32_t vertex : triangle.vertices) {
    hull.clear();
    AppendHull(primitive, vertex, span, hull);
    const V3d open = hull.front(), close = hull.back();
    V3d below(0), above(0);
    for (size_t j = 1; j + 1 < hull.size(); ++j) {
      const V3d off = hull[j] - (open + (double(j) / double(hull.size() - 1)) * (close - open));
      for (int axis = 0; axis < 3; ++axis) {
        below[axis] = std::min(below[axis], off[axis]);
        above[axis] = std::max(above[axis], off[axis]);
      }
    }
    box.open.Extend(open + below);
    box.open.Extend(open + above);
    box.close.Extend(close + below);
    box.close.Extend(close + above);
  }
  return box;
}

/// The control points of a vertex over a span, at equal steps of it.
void OccluderMotion::AppendHull(const FramePrimitive& primitive, uint32_t vertex, int span,
                                std::vector<V3d>& hull) const {
  const auto append = [&](const RasterPoint& p) {
    hull.push_back(frame.view.ViewFromRaster(p) / scale - centre);
  };
  if (!moves || primitive.degree == 0) {
    append(frame.VertexAt(primitive, vertex, 0.5));
    return;
  }
  const RasterPoint* c = frame.ControlPoints(primitive, vertex);
  if (primitive.pieces >= spans) {
    const int count = primitive.pieces / spans * primitive.degree;
    for (int k = span * count; k <= (span + 1) * count; ++k) append(c[k]);
    return;
  }
  const int per_piece = spans / primitive.pieces;
  const int part = span % per_piece;
  RasterPoint cut[kMaxBezierDegree + 1];
  BezierPart(c + span / per_piece * primitive.degree, primitive.degree, double(part) / per_piece,
             double(part + 1) / per_piece, cut);
  for (int k = 0; k <= primitive.degree; ++k) append(cut[k]);
}

}  // namespace shutterline::engine
