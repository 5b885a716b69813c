#include "worker/engine/visibility/tile_triangles.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/math/tolerance.h"

namespace shutterline::engine {
namespace {

RasterPoint RelativeTo(const TileRect& rect, const RasterPoint& p) {
  return {p.x - rect.x * p.w, p.y - rect.y * p.w, p.z, p.w};
}

/// Signed distances of a point to the planes that bound the tile's frustum, up to positive factors;
/// negative is outside: left, right, top, bottom, near, far.
std::array<double, 6> PlaneDistances(const TileTriangles& tile, const RasterPoint& p) {
  return {p.x,       tile.rect.width * p.w - p.x, p.y, tile.rect.height * p.w - p.y,
          p.w - p.z, p.z - tile.far_depth * p.w};
}

/// Narrows [t_in, t_out] to the instants at which at least one vertex is inside each single plane. The
/// distance of a vertex is linear in t, so each vertex is inside from or up to one instant. Returns
/// false if nothing is left.
bool BoundTime(const TileTriangles& tile, TileTriangle& triangle) {
  std::array<std::array<double, 6>, 3> at_open;
  std::array<std::array<double, 6>, 3> at_close;
  for (int i = 0; i < 3; ++i) {
    at_open[i] = PlaneDistances(tile, triangle.open[i]);
    at_close[i] = triangle.moves ? PlaneDistances(tile, triangle.close[i]) : at_open[i];
  }
  for (int plane = 0; plane < 6; ++plane) {
    double in = 1;
    double out = 0;
    for (int i = 0; i < 3; ++i) {
      const double a = at_open[i][plane];
      const double b = at_close[i][plane];
      if (a >= 0) in = 0;
      if (b >= 0) out = 1;
      if (a < 0 && b >= 0) in = std::min(in, a / (a - b));
      if (a >= 0 && b < 0) out = std::max(out, a / (a - b));
    }
    triangle.t_in = std::max(triangle.t_in, in);
    triangle.t_out = std::min(triangle.t_out, out);
  }
  // A few roundings' worth of slack on either side: instants in between are decided exactly later.
  triangle.t_in = std::max(0.0, triangle.t_in - 1e-9);
  triangle.t_out = std::min(1.0, triangle.t_out + 1e-9);
  return triangle.t_in <= triangle.t_out;
}

/// How far vertices move over the shutter, as far as the tile can tell; it decides how finely time is cut.
double MotionPixels(const TileTriangles& tile, const TileTriangle& triangle, bool in_front) {
  double motion = in_front ? 0 : kNearCrossingMotionPixels;
  const auto guarded = [](double position, int size) {
    return std::clamp(position, -kMotionGuardPixels, size + kMotionGuardPixels);
  };
  for (int i = 0; i < 3; ++i) {
    const RasterPoint& a = triangle.open[i];
    const RasterPoint& b = triangle.close[i];
    if (a.w < a.z || b.w < b.z) continue;
    motion = std::max(
        motion, std::hypot(guarded(b.x / b.w, tile.rect.width) - guarded(a.x / a.w, tile.rect.width),
                           guarded(b.y / b.w, tile.rect.height) - guarded(a.y / a.w, tile.rect.height)));
    if (a.z / a.w != b.z / b.w) motion = std::max(motion, kDepthMotionPixels);
  }
  return motion;
}

/// Bounds depth, motion and line numbers from the projected control points: a point of the moving
/// triangle is a convex combination of them, and so, while w > 0, is its projection.
void BoundProjection(const LinePattern& pattern, const TileTriangles& tile, TileTriangle& triangle) {
  const int ends = triangle.moves ? 2 : 1;
  bool in_front = true;
  double nearest = 0;
  for (int e = 0; e < ends; ++e) {
    for (const RasterPoint& p : e == 0 ? triangle.open : triangle.close) {
      triangle.crosses_near |= p.w < p.z || p.z < tile.far_depth * p.w;
      if (p.w < p.z || p.w <= 0) {
        in_front = false;
      } else {
        nearest = std::max(nearest, p.z / p.w);
      }
    }
  }
  triangle.nearest_depth = (in_front ? nearest : 1.0) * kDepthSlack;

  if (triangle.moves) triangle.motion_pixels = MotionPixels(tile, triangle, in_front);

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
    for (int e = 0; e < ends; ++e) {
      for (const RasterPoint& p : e == 0 ? triangle.open : triangle.close) {
        const double major = (family.major_is_x ? p.x : p.y) / p.w;
        const double minor = (family.major_is_x ? p.y : p.x) / p.w;
        const double number = (minor - family.slope * major - intercept_0) / family.spacing;
        rounding = std::max(rounding, 1e-15 * (std::abs(major) + std::abs(minor)) / family.spacing);
        low = std::min(low, number);
        high = std::max(high, number);
      }
    }
    // Numbers beyond any raster are cut before they are made integers.
    constexpr double kBeyond = 1e9;
    triangle.first_line[f] =
        int64_t(std::ceil(std::clamp(low, -kBeyond, kBeyond) - kLineRangeSlack - rounding));
    triangle.last_line[f] =
        int64_t(std::floor(std::clamp(high, -kBeyond, kBeyond) + kLineRangeSlack + rounding));
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
  for (const uint32_t id : candidates) {
    const FrameTriangle& source = frame.triangles[id];
    const FramePrimitive& primitive = frame.primitives[source.primitive];
    TileTriangle triangle;
    triangle.id = id;
    triangle.cull_back = traits[source.primitive].cull_back;
    triangle.needs_position = traits[source.primitive].needs_position;
    for (int i = 0; i < 3; ++i) {
      const RasterPoint& open = frame.ControlPoint(primitive, source.vertices[i], 0);
      triangle.open[i] = RelativeTo(rect, open);
      if (primitive.degree == 0) continue;
      const RasterPoint& close = frame.ControlPoint(primitive, source.vertices[i], 1);
      triangle.close[i] = RelativeTo(rect, close);
      // A triangle at rest in a moving primitive is at rest: it pays nothing for time.
      triangle.moves |= !(open == close);
    }
    if (!BoundTime(tile, triangle)) continue;
    BoundProjection(pattern, tile, triangle);
    triangle.shading_bins_log2 = ShadingBinsLog2(traits[source.primitive], triangle);
    tile.triangles.push_back(triangle);
  }
  std::sort(tile.triangles.begin(), tile.triangles.end(), [](const TileTriangle& a, const TileTriangle& b) {
    return a.nearest_depth != b.nearest_depth ? a.nearest_depth > b.nearest_depth : a.id < b.id;
  });
}

}  // namespace shutterline::engine
