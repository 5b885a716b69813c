#include "worker/engine/paper/barycentric.h"

#include <algorithm>

namespace shutterline::engine::paper {

SegmentBarycentric BarycentricOf(const TileTriangle& triangle, const SegmentLine& line, double l, double t) {
  const double minor = line.slope * l + line.intercept;
  const double x = line.major_is_x ? l : minor;
  const double y = line.major_is_x ? minor : l;
  RasterPoint v[3];
  triangle.VerticesAt(t, v);
  double u[3];
  double w[3];
  for (int i = 0; i < 3; ++i) {
    u[i] = v[i].x - x * v[i].w;
    w[i] = v[i].y - y * v[i].w;
  }
  // Twice the signed areas over the edges opposite to each vertex.
  double e[3];
  double sum = 0;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    const int k = (i + 2) % 3;
    e[i] = u[j] * w[k] - u[k] * w[j];
    sum += e[i];
  }
  const double sign = sum < 0 ? -1 : 1;
  double inside = 0;
  for (double& value : e) {
    value = std::max(0.0, sign * value);
    inside += value;
  }
  if (!(inside > 0)) return {1.0 / 3, 1.0 / 3};
  return {e[1] / inside, e[2] / inside};
}

}  // namespace shutterline::engine::paper
