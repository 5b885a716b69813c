#include "worker/engine/slice/tile_vertex.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "common/base/check.h"
#include "common/math/tolerance.h"
#include "worker/engine/slice/upper_slefe.h"

namespace shutterline::engine {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// The next floats above and below a time in [0, 1]; below 0 is 0. Adding zero takes the sign from a zero.
float Later(double time) {
  return std::bit_cast<float>(std::bit_cast<uint32_t>(float(time + 0.0)) + 1);
}
float Earlier(double time) {
  const auto bits = std::bit_cast<uint32_t>(float(time + 0.0));
  return std::bit_cast<float>(bits - uint32_t(bits != 0));
}

using Planes = std::array<double, TileVertex::kPlanes>;

/// Extends [in, out], by plane, by the times at which Bezier curves of distances, over [begin, begin +
/// length], may be at least zero.
void ExtendByPiece(const std::array<Planes, kMaxMotionDegree + 1>& curves, int degree, double begin,
                   double length, Planes& in, Planes& out) {
  std::array<Planes, kSlefeSegments + 1> upper;
  UpperSlefe(curves, degree, upper);
  constexpr double kSegment = 1.0 / double(kSlefeSegments);
  for (size_t k = 0; k < TileVertex::kPlanes; ++k) {
    if (upper[0][k] >= 0) {
      in[k] = std::min(in[k], begin);
      out[k] = std::max(out[k], begin);
    }
    for (size_t j = 0; j < kSlefeSegments; ++j) {
      const double a = upper[j][k];
      const double b = upper[j + 1][k];
      if (b >= 0) out[k] = std::max(out[k], begin + length * kSegment * double(j + 1));
      if ((a >= 0) == (b >= 0)) continue;
      const double passes = begin + length * kSegment * (double(j) + a / (a - b));
      in[k] = std::min(in[k], passes);
      out[k] = std::max(out[k], passes);
    }
  }
}

bool IsInFront(const RasterPoint& p) {
  return p.w >= p.z && p.w > 0;
}

}  // namespace

/// What is gathered of the control points of a path.
struct TileVertexMaker::Bounds {
  double rounding = 0;
  double x = 0, y = 0, depth = 0;  ///< Of the point before, cut.
};

TileVertexMaker::TileVertexMaker(const FrameScene& frame, const TileRect& rect, const LinePattern& pattern)
    : frame_(frame),
      x_(rect.x),
      y_(rect.y),
      width_(rect.width),
      height_(rect.height),
      far_depth_(frame.view.FarDepth()),
      families_(pattern.families().size()) {
  SL_CHECK(families_ <= slope_.size());
  for (size_t f = 0; f < families_; ++f) {
    major_is_x_[f] = pattern.families()[f].major_is_x;
    slope_[f] = pattern.families()[f].slope;
  }
}

void TileVertexMaker::PlaneDistances(const RasterPoint& p, Distances& distances) const {
  // Signed distances up to positive factors; negative is outside.
  distances = {p.x, width_ * p.w - p.x, p.y, height_ * p.w - p.y, p.w - p.z, p.z - far_depth_ * p.w, 0, 0};
}

void TileVertexMaker::Extend(const RasterPoint& p, bool is_first, TileVertex& vertex, Bounds& bounds) const {
  const double x = p.x / p.w;
  const double y = p.y / p.w;
  const double depth = p.z / p.w;
  vertex.nearest = std::max(vertex.nearest, depth);
  for (size_t f = 0; f < families_; ++f) {
    const double row = (major_is_x_[f] ? y : x) - slope_[f] * (major_is_x_[f] ? x : y);
    vertex.row_low[f] = std::min(vertex.row_low[f], row);
    vertex.row_high[f] = std::max(vertex.row_high[f], row);
  }
  bounds.rounding = std::max(bounds.rounding, 1e-15 * (std::abs(x) + std::abs(y)));
  const double cut_x = std::clamp(x, -kMotionGuardPixels, width_ + kMotionGuardPixels);
  const double cut_y = std::clamp(y, -kMotionGuardPixels, height_ + kMotionGuardPixels);
  if (!is_first) {
    const double dx = cut_x - bounds.x;
    const double dy = cut_y - bounds.y;
    vertex.motion_pixels += std::sqrt(dx * dx + dy * dy);
    if (depth != bounds.depth) vertex.motion_pixels = std::max(vertex.motion_pixels, kDepthMotionPixels);
  }
  bounds.x = cut_x;
  bounds.y = cut_y;
  bounds.depth = depth;
}

void TileVertexMaker::Finish(const Bounds& bounds, TileVertex& vertex) const {
  if (vertex.in_front) {
    for (size_t f = 0; f < families_; ++f) {
      vertex.row_low[f] -= kLineRangeSlack + bounds.rounding;
      vertex.row_high[f] += kLineRangeSlack + bounds.rounding;
    }
    return;
  }
  vertex.row_low.fill(-kInfinity);
  vertex.row_high.fill(kInfinity);
  vertex.nearest = 1;
  if (vertex.moves) vertex.motion_pixels = std::max(vertex.motion_pixels, kNearCrossingMotionPixels);
}

void TileVertexMaker::Make(uint32_t primitive_number, uint32_t number, TileVertex& vertex) const {
  const FramePrimitive& primitive = frame_.primitives[primitive_number];
  const RasterPoint* points = frame_.ControlPoints(primitive, number);
  const int count = primitive.PointsPerVertex();
  vertex.vertex = number;
  vertex.primitive = primitive_number;
  for (int i = 1; i < count; ++i) vertex.moves |= !(points[i] == points[0]);
  vertex.row_low.fill(kInfinity);
  vertex.row_high.fill(-kInfinity);
  vertex.open = RelativeToTile(points[0]);
  vertex.curved = vertex.moves && count > 2;
  vertex.close = vertex.moves && !vertex.curved ? RelativeToTile(points[1]) : vertex.open;
  if (vertex.curved) {
    MakeCurved(primitive, points, vertex);
  } else {
    MakeStraight(vertex.open, vertex.close, vertex);
  }
}

void TileVertexMaker::MakeStraight(const RasterPoint& open, const RasterPoint& close,
                                   TileVertex& vertex) const {
  // Bounds from the projected ends, of which the path's projection is a convex combination as long as both
  // are in front.
  Bounds bounds;
  vertex.in_front = IsInFront(open) && IsInFront(close);
  if (IsInFront(open)) Extend(open, true, vertex, bounds);
  if (vertex.in_front && vertex.moves) Extend(close, false, vertex, bounds);
  Finish(bounds, vertex);

  Distances from, to;
  PlaneDistances(open, from);
  PlaneDistances(close, to);
  bool always = true;
  for (size_t p = 0; p < TileVertex::kPlanes; ++p) {
    const double a = from[p];
    const double b = to[p];
    const double passes = a / (a - b);  // Where it is not a share, nobody looks at it.
    const double in = a >= 0 ? 0 : b >= 0 ? passes : 1;
    const double out = b >= 0 ? 1 : a >= 0 ? passes : 0;
    vertex.in[p] = Earlier(in);
    vertex.out[p] = Later(out);
    always &= (a >= 0) & (b >= 0);
  }
  vertex.always_inside = always;
}

void TileVertexMaker::MakeCurved(const FramePrimitive& primitive, const RasterPoint* points,
                                 TileVertex& vertex) const {
  const int degree = primitive.degree;
  const double length = 1.0 / primitive.pieces;
  Bounds bounds;
  std::array<double, TileVertex::kPlanes> in;
  std::array<double, TileVertex::kPlanes> out;
  in.fill(1);
  out.fill(0);
  std::array<Distances, kMaxMotionDegree + 1> curve{};
  for (int piece = 0; piece < primitive.pieces; ++piece) {
    for (int i = 0; i <= degree; ++i) {
      const RasterPoint p = RelativeToTile(points[piece * degree + i]);
      PlaneDistances(p, curve[size_t(i)]);
      if (piece > 0 && i == 0) continue;  // A piece begins where the one before ends.
      vertex.in_front &= IsInFront(p);
      if (vertex.in_front) Extend(p, i == 0, vertex, bounds);
    }
    ExtendByPiece(curve, degree, piece * length, length, in, out);
  }
  Finish(bounds, vertex);
  for (size_t k = 0; k < TileVertex::kPlanes; ++k) {
    vertex.in[k] = Earlier(in[k]);
    vertex.out[k] = Later(out[k]);
  }
}

}  // namespace shutterline::engine
