#include "worker/engine/visibility/tile_triangles.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/math/tolerance.h"
#include "worker/engine/accel/time_bounds.h"

namespace shutterline::engine {
namespace {

RasterPoint RelativeTo(const TileRect& rect, const RasterPoint& p) {
  return {p.x - rect.x * p.w, p.y - rect.y * p.w, p.z, p.w};
}

/// A triangle's control points relative to the tile, `count` a corner: all of corner 0, then of 1 and 2.
struct ControlPoints {
  std::span<const RasterPoint> all;
  size_t count;

  std::span<const RasterPoint> OfCorner(size_t i) const { return all.subspan(i * count, count); }
};

/// How far vertices move over the shutter, as far as the tile can tell; it decides how finely time is cut.
/// Paths are measured along their control points.
double MotionPixels(const TileTriangles& tile, const ControlPoints& points, bool in_front) {
  double motion = in_front ? 0 : kNearCrossingMotionPixels;
  const auto guarded = [](double position, int size) {
    return std::clamp(position, -kMotionGuardPixels, size + kMotionGuardPixels);
  };
  for (size_t k = 0; k < 3; ++k) {
    const std::span<const RasterPoint> path = points.OfCorner(k);
    double length = 0;
    for (size_t i = 1; i < path.size(); ++i) {
      const RasterPoint& a = path[i - 1];
      const RasterPoint& b = path[i];
      if (a.w < a.z || b.w < b.z) continue;
      length += std::hypot(guarded(b.x / b.w, tile.rect.width) - guarded(a.x / a.w, tile.rect.width),
                           guarded(b.y / b.w, tile.rect.height) - guarded(a.y / a.w, tile.rect.height));
      if (a.z / a.w != b.z / b.w) motion = std::max(motion, kDepthMotionPixels);
    }
    motion = std::max(motion, length);
  }
  return std::min(motion, kMostMotionPixels);
}

/// Bounds depth, motion and line numbers from the projected control points: a point of the moving
/// triangle is a convex combination of them, and so, while w > 0, is its projection.
void BoundProjection(const LinePattern& pattern, const TileTriangles& tile, const ControlPoints& points,
                     TileTriangle& triangle) {
  bool in_front = true;
  double nearest = 0;
  for (const RasterPoint& p : points.all) {
    triangle.crosses_near |= p.w < p.z || p.z < tile.far_depth * p.w;
    if (p.w < p.z || p.w <= 0) {
      in_front = false;
    } else {
      nearest = std::max(nearest, p.z / p.w);
    }
  }
  triangle.nearest_depth = (in_front ? nearest : 1.0) * kDepthSlack;

  if (triangle.moves) triangle.motion_pixels = MotionPixels(tile, points, in_front);

  for (int f = 0; f < int(pattern.families().size()); ++f) {
    const LineFamily& family = pattern.families()[f];
    triangle.first_line[f] = std::numeric_limits<int64_t>::min();
    triangle.last_line[f] = std::numeric_limits<int64_t>::max();
    if (!in_front) continue;
    const double major_corner = family.major_is_x ? tile.rect.x : tile.rect.y;
    const double minor_corner = family.major_is_x ? tile.rect.y : tile.rect.x;
    const double intercept_0 = family.offset + family.slope * major_corner - minor_corner;
    double low = std::numeric_limits<double>::infinity();
    double high = -low;
    double rounding = 0;
    for (const RasterPoint& p : points.all) {
      const double major = (family.major_is_x ? p.x : p.y) / p.w;
      const double minor = (family.major_is_x ? p.y : p.x) / p.w;
      const double number = (minor - family.slope * major - intercept_0) / family.spacing;
      rounding = std::max(rounding, 1e-15 * (std::abs(major) + std::abs(minor)) / family.spacing);
      low = std::min(low, number);
      high = std::max(high, number);
    }
    // Numbers beyond any raster are cut before they are made integers.
    constexpr double kBeyond = 1e9;
    triangle.first_line[f] =
        int64_t(std::ceil(std::clamp(low, -kBeyond, kBeyond) - kLineRangeSlack - rounding));
    triangle.last_line[f] =
        int64_t(std::floor(std::clamp(high, -kBeyond, kBeyond) + kLineRangeSlack + rounding));
  }
}

/// Appends a triangle's curves as TileTriangle::curve wants them.
void AppendCurves(std::span<const RasterPoint> relative, size_t count, int degree, int pieces,
                  std::vector<RasterPoint>& curves) {
  size_t next = curves.size();
  curves.resize(next + 3 * size_t(pieces) * (size_t(degree) + 1));
  for (size_t piece = 0; piece < size_t(pieces); ++piece) {
    for (size_t k = 0; k < 3; ++k) {
      BezierToPower(&relative[k * count + piece * size_t(degree)], degree, &curves[next]);
      next += size_t(degree) + 1;
    }
  }
}

/// A texture that moves under a pixel is blurred by shading it at several times; what varies linearly
/// over a triangle (vertex colours) or slowly (a head light) is exact or good at one mean position.
uint8_t ShadingBinsLog2(const PrimitiveTraits& traits, const TileTriangle& triangle) {
  constexpr int kMost = 6;
  if (!traits.textured || !triangle.moves) return 0;
  int log2 = 0;
  while (log2 < kMost && double(1 << log2) < triangle.motion_pixels) ++log2;
  return uint8_t(log2);
}

}  // namespace

void SetUpTile(const FrameScene& frame, std::span<const PrimitiveTraits> traits, const LinePattern& pattern,
               const TileRect& rect, std::span<const uint32_t> candidates, TileTriangles& tile) {
  tile.rect = rect;
  tile.far_depth = frame.view.FarDepth();
  tile.triangles.clear();
  tile.triangles.reserve(candidates.size());
  tile.curves.clear();
  const RasterBox box{0, double(rect.width), 0, double(rect.height), tile.far_depth};
  std::vector<RasterPoint> relative;
  std::vector<size_t> first_coefficient;  // One a triangle kept; curves may still move in memory.
  for (const uint32_t id : candidates) {
    const FrameTriangle& source = frame.triangles[id];
    const FramePrimitive& primitive = frame.primitives[source.primitive];
    TileTriangle triangle;
    triangle.id = id;
    triangle.cull_back = traits[source.primitive].cull_back;
    triangle.needs_position = traits[source.primitive].needs_position;
    for (const uint32_t vertex : source.vertices) {
      const RasterPoint* points = frame.ControlPoints(primitive, vertex);
      for (int i = 1; i < primitive.PointsPerVertex(); ++i) triangle.moves |= !(points[i] == points[0]);
    }
    // A triangle at rest in a moving primitive is at rest: it pays nothing for time.
    const size_t count = triangle.moves ? size_t(primitive.PointsPerVertex()) : 1;
    relative.resize(3 * count);
    for (size_t k = 0; k < 3; ++k) {
      const RasterPoint* points = frame.ControlPoints(primitive, source.vertices[k]);
      for (size_t i = 0; i < count; ++i) relative[k * count + i] = RelativeTo(rect, points[i]);
      triangle.open[k] = relative[k * count];
      triangle.close[k] = relative[k * count + count - 1];
    }
    const TimeInterval inside = TimesInside({&relative[0], &relative[count], &relative[2 * count]},
                                            triangle.moves ? primitive.degree : 0, primitive.pieces, box);
    if (inside.IsEmpty()) continue;
    triangle.t_in = inside.in;
    triangle.t_out = inside.out;
    BoundProjection(pattern, tile, {relative, count}, triangle);
    triangle.shading_bins_log2 = ShadingBinsLog2(traits[source.primitive], triangle);
    first_coefficient.push_back(tile.curves.size());
    if (count > 2) {
      triangle.degree = primitive.degree;
      triangle.pieces = primitive.pieces;
      triangle.linear_pieces = primitive.linear_pieces;
      AppendCurves(relative, count, primitive.degree, primitive.pieces, tile.curves);
    }
    tile.triangles.push_back(triangle);
  }
  for (size_t i = 0; i < tile.triangles.size(); ++i) {
    TileTriangle& triangle = tile.triangles[i];
    if (triangle.degree * triangle.pieces > 1) triangle.curve = &tile.curves[first_coefficient[i]];
  }
  std::sort(tile.triangles.begin(), tile.triangles.end(), [](const TileTriangle& a, const TileTriangle& b) {
    return a.nearest_depth != b.nearest_depth ? a.nearest_depth > b.nearest_depth : a.id < b.id;
  });
}

}  // namespace shutterline::engine
