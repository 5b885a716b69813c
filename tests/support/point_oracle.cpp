#include "tests/support/point_oracle.h"

namespace shutterline::engine {
namespace {

/// A vertex relative to the point that is looked at: it is at the origin after division by w.
struct Relative {
  double x, y;
};

double Cross(const Relative& a, const Relative& b) {
  return a.x * b.y - a.y * b.x;
}

}  // namespace

std::optional<VisiblePoint> SeeAt(const FrameScene& frame, double x, double y, double t) {
  std::optional<VisiblePoint> best;
  for (uint32_t i = 0; i < frame.triangles.size(); ++i) {
    const FrameTriangle& triangle = frame.triangles[i];
    const FramePrimitive& primitive = frame.primitives[triangle.primitive];
    RasterPoint p[3];
    Relative r[3];
    for (int k = 0; k < 3; ++k) {
      p[k] = frame.VertexAt(primitive, triangle.vertices[k], t);
      r[k] = {p[k].x - x * p[k].w, p[k].y - y * p[k].w};
    }
    const double e0 = Cross(r[1], r[2]), e1 = Cross(r[2], r[0]), e2 = Cross(r[0], r[1]);
    const double sum = e0 + e1 + e2;
    const bool inside = (e0 >= 0 && e1 >= 0 && e2 >= 0) || (e0 <= 0 && e1 <= 0 && e2 <= 0);
    if (!inside || sum == 0) continue;
    // Raster y points down, so counter-clockwise as one looks is a negative area.
    if (!primitive.material->double_sided && sum > 0) continue;
    const double b1 = e1 / sum, b2 = e2 / sum;
    const RasterPoint hit = (e0 / sum) * p[0] + b1 * p[1] + b2 * p[2];
    if (!(hit.w > 0) || hit.z > hit.w || hit.z < frame.view.FarDepth() * hit.w) continue;
    const double depth = hit.z / hit.w;
    if (!best || depth > best->depth) best = VisiblePoint{i, b1, b2, depth};
  }
  return best;
}

}  // namespace shutterline::engine
