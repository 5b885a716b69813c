#include "worker/engine/slice/tile_mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "common/math/tolerance.h"
#include "worker/engine/slice/moving_vertices.h"

namespace shutterline::engine {
namespace {

RasterPoint RelativeTo(const TileRect& rect, const RasterPoint& p) {
  return {p.x - rect.x * p.w, p.y - rect.y * p.w, p.z, p.w};
}

/// Signed distances of a point to the planes that bound the tile's frustum, up to positive factors;
/// negative is outside: left, right, top, bottom, near, far.
std::array<double, 6> PlaneDistances(const TileRect& rect, double far_depth, const RasterPoint& p) {
  return {p.x, rect.width * p.w - p.x, p.y, rect.height * p.w - p.y, p.w - p.z, p.z - far_depth * p.w};
}

/// Extends [in, out] by the times at which a Bezier curve of distances, over [begin, begin + length], may be
/// at least zero: the curve lies within the hull of its control polygon, and that meets zero first and last
/// where some line between a point inside and one outside does.
void ExtendInside(std::span<const double> distances, double begin, double length, double& in, double& out) {
  const int degree = int(distances.size()) - 1;
  const auto time = [&](int i) { return begin + length * double(i) / double(degree); };
  for (int i = 0; i <= degree; ++i) {
    if (distances[size_t(i)] < 0) continue;
    in = std::min(in, time(i));
    out = std::max(out, time(i));
    for (int k = 0; k <= degree; ++k) {
      if (distances[size_t(k)] >= 0) continue;
      const double share = distances[size_t(k)] / (distances[size_t(k)] - distances[size_t(i)]);
      const double at = time(k) + share * (time(i) - time(k));
      in = std::min(in, at);
      out = std::max(out, at);
    }
  }
}

/// A texture that moves under a pixel is blurred by shading it at several times; what varies linearly
/// over a triangle (vertex colours) or slowly (a head light) is exact or good at one mean position.
uint8_t ShadingBinsLog2(bool textured, double motion_pixels) {
  constexpr int kMost = 6;
  if (!textured) return 0;
  int log2 = 0;
  while (log2 < kMost && double(1 << log2) < motion_pixels) ++log2;
  return uint8_t(log2);
}

float RoundedUp(double x) {
  return std::nextafter(float(x), std::numeric_limits<float>::infinity());
}
float RoundedDown(double x) {
  return std::nextafter(float(x), -std::numeric_limits<float>::infinity());
}

}  // namespace

TileVertex TileMesh::MakeVertex(uint32_t number, uint32_t primitive_number,
                                const LinePattern& pattern) const {
  const FramePrimitive& primitive = frame_->primitives[primitive_number];
  const RasterPoint* points = frame_->ControlPoints(primitive, number);
  const int count = primitive.PointsPerVertex();
  const int last = count - 1;
  TileVertex vertex{.vertex = number, .primitive = primitive_number, .curved = count > 2, .in_front = true};
  for (int i = 1; i < count; ++i) vertex.moves |= !(points[i] == points[0]);
  vertex.curved &= vertex.moves;
  vertex.open = RelativeTo(rect_, points[0]);
  vertex.close = vertex.moves && !vertex.curved ? RelativeTo(rect_, points[last]) : vertex.open;
  const int used = vertex.moves ? count : 1;

  // Bounds from the projected control points, of which the path's projection is a convex combination as
  // long as all are in front.
  const auto guarded = [](double position, int size) {
    return std::clamp(position, -kMotionGuardPixels, size + kMotionGuardPixels);
  };
  vertex.row_low.fill(std::numeric_limits<double>::infinity());
  vertex.row_high.fill(-std::numeric_limits<double>::infinity());
  double rounding = 0;
  V2d before;
  double depth_before = 0;
  for (int i = 0; i < used; ++i) {
    const RasterPoint p = RelativeTo(rect_, points[i]);
    if (p.w < p.z || p.w <= 0) {
      vertex.in_front = false;
      break;
    }
    const V2d at(p.x / p.w, p.y / p.w);
    const double depth = p.z / p.w;
    vertex.nearest = std::max(vertex.nearest, depth);
    for (size_t f = 0; f < pattern.families().size(); ++f) {
      const LineFamily& family = pattern.families()[f];
      const double row = (family.major_is_x ? at.y : at.x) - family.slope * (family.major_is_x ? at.x : at.y);
      vertex.row_low[f] = std::min(vertex.row_low[f], row);
      vertex.row_high[f] = std::max(vertex.row_high[f], row);
    }
    rounding = std::max(rounding, 1e-15 * (std::abs(at.x) + std::abs(at.y)));
    const V2d cut(guarded(at.x, rect_.width), guarded(at.y, rect_.height));
    if (i > 0) {
      vertex.motion_pixels += (cut - before).length();
      if (depth != depth_before) vertex.motion_pixels = std::max(vertex.motion_pixels, kDepthMotionPixels);
    }
    before = cut;
    depth_before = depth;
  }
  if (vertex.in_front) {
    for (size_t f = 0; f < 2; ++f) {
      vertex.row_low[f] -= kLineRangeSlack + rounding;
      vertex.row_high[f] += kLineRangeSlack + rounding;
    }
  } else {
    vertex.row_low.fill(-std::numeric_limits<double>::infinity());
    vertex.row_high.fill(std::numeric_limits<double>::infinity());
    vertex.nearest = 1;
    if (vertex.moves) vertex.motion_pixels = std::max(vertex.motion_pixels, kNearCrossingMotionPixels);
  }

  // When it is inside each plane.
  std::array<double, 6> in;
  std::array<double, 6> out;
  in.fill(1);
  out.fill(0);
  if (!vertex.moves) {
    const auto distances = PlaneDistances(rect_, far_depth_, vertex.open);
    for (size_t p = 0; p < 6; ++p) {
      if (distances[p] >= 0) in[p] = 0, out[p] = 1;
    }
  } else {
    const int degree = primitive.degree;
    std::array<std::array<double, kMaxMotionDegree + 1>, 6> curve;
    for (int piece = 0; piece < primitive.pieces; ++piece) {
      for (int i = 0; i <= degree; ++i) {
        const auto distances =
            PlaneDistances(rect_, far_depth_, RelativeTo(rect_, points[piece * degree + i]));
        for (size_t p = 0; p < 6; ++p) curve[p][size_t(i)] = distances[p];
      }
      const double length = 1.0 / primitive.pieces;
      for (size_t p = 0; p < 6; ++p) {
        ExtendInside({curve[p].data(), size_t(degree) + 1}, piece * length, length, in[p], out[p]);
      }
    }
  }
  for (size_t p = 0; p < 6; ++p) {
    vertex.in[p] = RoundedDown(in[p]);
    vertex.out[p] = RoundedUp(out[p]);
  }
  return vertex;
}

TileMesh::Power TileMesh::PowerAt(const TileVertex& vertex, double t) const {
  Power power;
  auto& c = power.coefficients;
  if (!vertex.curved) {
    c[0] = vertex.open;
    c[1] = vertex.close - vertex.open;
    return power;
  }
  const FramePrimitive& primitive = frame_->primitives[vertex.primitive];
  const CurvePosition at = primitive.PositionAt(t);
  const RasterPoint* points = frame_->ControlPoints(primitive, vertex.vertex) + at.piece * primitive.degree;
  std::array<RasterPoint, 4> p;
  for (int i = 0; i <= primitive.degree; ++i) p[size_t(i)] = RelativeTo(rect_, points[i]);
  c[0] = p[0];
  if (primitive.degree == 1) {
    c[1] = p[1] - p[0];
  } else if (primitive.degree == 2) {
    c[1] = 2 * (p[1] - p[0]);
    c[2] = (p[2] - p[1]) - (p[1] - p[0]);
  } else {
    const RasterPoint d0 = p[1] - p[0];
    const RasterPoint d1 = p[2] - p[1];
    const RasterPoint d2 = p[3] - p[2];
    c[1] = 3 * d0;
    c[2] = 3 * (d1 - d0);
    c[3] = (d2 - d1) - (d1 - d0);
  }
  power.time_scale = primitive.pieces;
  power.time_offset = -double(at.piece);
  return power;
}

void TileMesh::Build(const TileInput& input, const LinePattern& pattern) {
  frame_ = &input.frame;
  rect_ = input.rect;
  far_depth_ = input.frame.view.FarDepth();
  vertices_.clear();
  triangles_.clear();
  numbering_.Reset(3 * input.candidates.size());
  for (const uint32_t id : input.candidates) {
    const FrameTriangle& source = frame_->triangles[id];
    const PrimitiveTraits& traits = input.traits[source.primitive];
    TileMeshTriangle triangle{
        .id = id, .cull_back = traits.cull_back, .needs_position = traits.needs_position};
    std::array<float, 6> in;
    std::array<float, 6> out;
    in.fill(1);
    out.fill(0);
    double nearest = 0;
    double motion = 0;
    triangle.row_low.fill(std::numeric_limits<double>::infinity());
    triangle.row_high.fill(-std::numeric_limits<double>::infinity());
    for (size_t i = 0; i < 3; ++i) {
      bool is_new = false;
      const uint32_t number = numbering_.NumberOf(source.vertices[i], is_new);
      if (is_new) vertices_.push_back(MakeVertex(source.vertices[i], source.primitive, pattern));
      const TileVertex& vertex = vertices_[number];
      triangle.vertices[i] = number;
      triangle.moves |= vertex.moves;
      nearest = std::max(nearest, vertex.nearest);
      motion = std::max(motion, vertex.motion_pixels);
      for (size_t p = 0; p < 6; ++p) {
        in[p] = std::min(in[p], vertex.in[p]);
        out[p] = std::max(out[p], vertex.out[p]);
      }
      for (size_t f = 0; f < 2; ++f) {
        triangle.row_low[f] = std::min(triangle.row_low[f], vertex.row_low[f]);
        triangle.row_high[f] = std::max(triangle.row_high[f], vertex.row_high[f]);
      }
    }
    for (size_t p = 0; p < 6; ++p) {
      triangle.t_in = std::max(triangle.t_in, double(in[p]));
      triangle.t_out = std::min(triangle.t_out, double(out[p]));
    }
    if (triangle.t_in > triangle.t_out) continue;
    triangle.nearest = RoundedUp(nearest) * kFloatDepthSlack;
    triangle.motion_pixels = RoundedUp(motion);
    if (triangle.moves) triangle.shading_bins_log2 = ShadingBinsLog2(traits.textured, motion);
    triangles_.push_back(triangle);
  }
  std::sort(triangles_.begin(), triangles_.end(), [](const TileMeshTriangle& a, const TileMeshTriangle& b) {
    return a.nearest != b.nearest ? a.nearest > b.nearest : a.id < b.id;
  });
  ids_.clear();
  for (const TileMeshTriangle& triangle : triangles_) ids_.push_back(triangle.id);
  ids_.resize(Padded(ids_.size()));
}

}  // namespace shutterline::engine
