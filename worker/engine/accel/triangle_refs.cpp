#include "worker/engine/accel/triangle_refs.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/job/tile.h"
#include "common/math/bezier.h"

namespace shutterline::engine {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
/// Cutting once more must leave no more than this share of the area.
constexpr double kWorthwhile = 0.9;
/// Pixels added to a box when boxes are compared. A box reaches tiles as if it were a tile longer; but boxes
/// of neighbouring spans reach the same.
constexpr double kBorder = kTileSize / 2.0;
/// Embree takes no coordinates from about 2^60 on. Scaled ones stay below 2^21.
constexpr float kEmbreeLimit = 0x1p60f;

/// The nearest float not above (not below) `value`.
float RoundDown(double value) {
  const float f = float(std::clamp(value, -double(kEmbreeLimit), double(kEmbreeLimit)));
  return double(f) > value ? std::nextafter(f, -std::numeric_limits<float>::infinity()) : f;
}
float RoundUp(double value) {
  return -RoundDown(-value);
}

/// How far ViewFromRaster(p) may be from the exact view-space point: roundings of its terms and of the hull's
/// own points.
V3d InverseError(const FrameView& view, const RasterPoint& p) {
  constexpr double kRoundings = 16 * std::numeric_limits<double>::epsilon();
  return kRoundings * V3d((std::abs(p.x) + std::abs(view.center_x * p.w)) / std::abs(view.scale_x),
                          (std::abs(p.y) + std::abs(view.center_y * p.w)) / std::abs(view.scale_y),
                          view.perspective ? std::abs(p.w)
                                           : std::abs(view.zfar) + std::abs(p.z * (view.zfar - view.znear)));
}

/// Places of a triangle's corners at equal steps of the shutter, in the raster.
class Sweep {
 public:
  /// False if a corner is behind the near plane at one of the steps.
  bool Follow(const FrameScene& frame, uint32_t triangle, int steps) {
    const FrameTriangle& corners = frame.triangles[triangle];
    const FramePrimitive& primitive = frame.primitives[corners.primitive];
    for (int i = 0; i <= steps; ++i) {
      for (size_t k = 0; k < 3; ++k) {
        const RasterPoint p = frame.VertexAt(primitive, corners.vertices[k], double(i) / steps);
        if (!(p.w > 0 && p.z <= p.w)) return false;
        places_[size_t(i)][k] = {p.x / p.w, p.y / p.w};
      }
    }
    steps_ = steps;
    return true;
  }

  /// Of the boxes of `spans` spans, a border added to each of their sides.
  double Area(int spans) const {
    double area = 0;
    const int steps = steps_ / spans;
    for (int span = 0; span < spans; ++span) {
      V2d low(kInfinity), high(-kInfinity);
      for (int i = span * steps; i <= (span + 1) * steps; ++i) {
        for (const V2d& p : places_[size_t(i)]) {
          low = {std::min(low.x, p.x), std::min(low.y, p.y)};
          high = {std::max(high.x, p.x), std::max(high.y, p.y)};
        }
      }
      area += (high.x - low.x + kBorder) * (high.y - low.y + kBorder);
    }
    return area;
  }

 private:
  std::array<std::array<V2d, 3>, kMaxRefSpans + 1> places_;
  int steps_ = 0;
};

}  // namespace

void AppendHull(const FrameScene& frame, const TriangleRef& ref, std::vector<RasterPoint>& points) {
  const FrameTriangle& triangle = frame.triangles[ref.triangle];
  const FramePrimitive& primitive = frame.primitives[triangle.primitive];
  for (const uint32_t vertex : triangle.vertices) {
    const RasterPoint* c = frame.ControlPoints(primitive, vertex);
    if (ref.spans <= primitive.pieces) {
      const int count = primitive.pieces / ref.spans * primitive.degree;
      points.insert(points.end(), c + ref.span * count, c + (ref.span + 1) * count + 1);
      continue;
    }
    const int per_piece = ref.spans / primitive.pieces;
    const int part = ref.span % per_piece;
    RasterPoint cut[kMaxBezierDegree + 1];
    BezierPart(c + ref.span / per_piece * primitive.degree, primitive.degree, double(part) / per_piece,
               double(part + 1) / per_piece, cut);
    points.insert(points.end(), cut, cut + primitive.degree + 1);
  }
}

int SpansFor(const FrameScene& frame, uint32_t triangle) {
  const FramePrimitive& primitive = frame.primitives[frame.triangles[triangle].primitive];
  // The primitive's fastest corner does not cross two tiles: no box is long.
  if (primitive.degree == 0 || primitive.motion_pixels < 2 * kTileSize) return 1;
  Sweep sweep;
  if (!sweep.Follow(frame, triangle, kMaxRefSpans)) return 1;
  int best = 1;
  double least = sweep.Area(1), price = 1;
  for (int spans = 2; spans <= kMaxRefSpans; spans *= 2) {
    price /= kWorthwhile;
    const double cost = price * sweep.Area(spans);
    if (cost >= least) continue;
    least = cost;
    best = spans;
  }
  return best;
}

ViewBounds BoundsOf(const FrameScene& frame, const TriangleRef& ref, double scale) {
  thread_local std::vector<RasterPoint> points;
  points.clear();
  AppendHull(frame, ref, points);
  V3d lower(kInfinity), upper(-kInfinity);
  for (const RasterPoint& point : points) {
    const V3d p = frame.view.ViewFromRaster(point);
    const V3d error = InverseError(frame.view, point);
    for (int axis = 0; axis < 3; ++axis) {
      lower[axis] = std::min(lower[axis], p[axis] - error[axis]);
      upper[axis] = std::max(upper[axis], p[axis] + error[axis]);
    }
  }
  ViewBounds bounds;
  for (int axis = 0; axis < 3; ++axis) {
    bounds.lower[size_t(axis)] = RoundDown(lower[axis] / scale);
    bounds.upper[size_t(axis)] = RoundUp(upper[axis] / scale);
  }
  return bounds;
}

std::vector<TriangleRef> MakeTriangleRefs(const FrameScene& frame) {
  const size_t count = frame.triangles.size();
  std::vector<uint8_t> spans(count);
  tbb::parallel_for(tbb::blocked_range<size_t>(0, count, 1024), [&](const tbb::blocked_range<size_t>& part) {
    for (size_t i = part.begin(); i < part.end(); ++i) spans[i] = uint8_t(SpansFor(frame, uint32_t(i)));
  });
  std::vector<TriangleRef> refs;
  size_t total = 0;
  for (const uint8_t s : spans) total += s;
  // References are numbered by 32 bits as triangles are: a frame that huge is not cut at all.
  const bool cut = total < std::numeric_limits<uint32_t>::max();
  refs.reserve(cut ? total : count);
  for (size_t i = 0; i < count; ++i) {
    const uint8_t s = cut ? spans[i] : uint8_t{1};
    for (uint8_t span = 0; span < s; ++span) refs.push_back({uint32_t(i), span, s});
  }
  return refs;
}

}  // namespace shutterline::engine
