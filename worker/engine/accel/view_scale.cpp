#include "worker/engine/accel/view_scale.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <cmath>

namespace shutterline::engine {

double ViewScale(const FrameScene& frame) {
  const double largest = tbb::parallel_reduce(
      tbb::blocked_range<size_t>(0, frame.triangles.size(), 4096), 0.0,
      [&](const tbb::blocked_range<size_t>& range, double most) {
        for (size_t i = range.begin(); i < range.end(); ++i) {
          const FrameTriangle& triangle = frame.triangles[i];
          const FramePrimitive& primitive = frame.primitives[triangle.primitive];
          for (const uint32_t vertex : triangle.vertices) {
            const RasterPoint* points = frame.ControlPoints(primitive, vertex);
            for (int k = 0; k < primitive.PointsPerVertex(); ++k) {
              const V3d p = frame.view.ViewFromRaster(points[k]);
              most = std::max({most, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
            }
          }
        }
        return most;
      },
      [](double a, double b) { return std::max(a, b); });
  if (!(largest > 0) || !std::isfinite(largest)) return 1;
  return std::ldexp(1.0, std::ilogb(largest) - kViewScaleExponent);
}

}  // namespace shutterline::engine
