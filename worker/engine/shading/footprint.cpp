#include "worker/engine/shading/footprint.h"

#include <cmath>

namespace shutterline::engine {

std::array<RasterPoint, 3> CornersAt(const FrameScene& frame, uint32_t triangle, double t) {
  const FrameTriangle& source = frame.triangles[triangle];
  const FramePrimitive& primitive = frame.primitives[source.primitive];
  std::array<RasterPoint, 3> corners;
  for (size_t k = 0; k < 3; ++k) corners[k] = frame.VertexAt(primitive, source.vertices[k], t);
  return corners;
}

Footprint PixelFootprint(const std::array<RasterPoint, 3>& vertices, const Barycentric& at) {
  const RasterPoint edge1 = vertices[1] - vertices[0];
  const RasterPoint edge2 = vertices[2] - vertices[0];
  const RasterPoint p = vertices[0] + (at.b1 * edge1 + at.b2 * edge2);
  if (!(p.w > 0)) return {};
  // Differentiate (X / W, Y / W) by the quotient rule.
  const double x = p.x / p.w;
  const double y = p.y / p.w;
  const double dx_db1 = (edge1.x - x * edge1.w) / p.w;
  const double dx_db2 = (edge2.x - x * edge2.w) / p.w;
  const double dy_db1 = (edge1.y - y * edge1.w) / p.w;
  const double dy_db2 = (edge2.y - y * edge2.w) / p.w;
  const double determinant = dx_db1 * dy_db2 - dx_db2 * dy_db1;
  const Footprint footprint{.db1_dx = dy_db2 / determinant,
                            .db1_dy = -dx_db2 / determinant,
                            .db2_dx = -dy_db1 / determinant,
                            .db2_dy = dx_db1 / determinant};
  const bool finite = std::isfinite(footprint.db1_dx) && std::isfinite(footprint.db1_dy) &&
                      std::isfinite(footprint.db2_dx) && std::isfinite(footprint.db2_dy);
  return finite ? footprint : Footprint{};
}

Footprint PixelFootprintAt(const FrameScene& frame, uint32_t triangle, const Barycentric& at, double t) {
  return PixelFootprint(CornersAt(frame, triangle, t), at);
}

}  // namespace shutterline::engine
