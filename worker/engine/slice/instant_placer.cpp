#include "worker/engine/slice/instant_placer.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/math/tolerance.h"
#include "worker/engine/slice/near_clip.h"

namespace shutterline::engine {
namespace {

/// Triangles that are cut give at most three, from five corners.
constexpr size_t kMostCorners = 5;
constexpr size_t kMostPieces = 3;

/// A placed vertex.
struct LineVertex {
  double row = 0, position = 0;  ///< Pixels.
  double inverse_w = 0;
};

constexpr float kNothingLeft = -std::numeric_limits<float>::infinity();
constexpr float kAnything = std::numeric_limits<float>::infinity();

}  // namespace

void InstantPlacer::Begin(Stratum& stratum, const LineClass& lines, double t) {
  stratum_ = &stratum;
  lines_ = &lines;
  t_ = t;
  ++instant_;
  next_block_ = 0;
  next_clipped_ = 0;
  clipped_.count = 0;
  stratum.MoveTo(t);
  vertices_.Grow(stratum.vertices().size() + kPad);
  nearest_left_ = stratum.empty() ? kNothingLeft : stratum.block(0).nearest;
}

bool InstantPlacer::PlaceNext() {
  if (next_clipped_ < clipped_.count) {
    PlaceClipped();
    return true;
  }
  if (next_block_ >= stratum_->blocks()) return false;
  const Stratum::Block from = next_block_ == 0 ? Stratum::Block{} : stratum_->block(next_block_ - 1);
  const Stratum::Block& to = stratum_->block(next_block_++);
  const double far_depth = stratum_->mesh().far_depth();
  const MovingVertices& vertices = stratum_->vertices();
  // Whole vectors: a few are placed twice.
  if (to.straight > from.straight) {
    PlaceVertices(vertices, from.straight / kPad * kPad, to.straight, t_, far_depth, lines_->axes, vertices_);
  }
  if (to.curved > from.curved) {
    const size_t first = vertices.first_curved();
    PlaceVertices(vertices, first + from.curved / kPad * kPad, first + to.curved, t_, far_depth, lines_->axes,
                  vertices_);
  }
  PlaceTriangles(stratum_->triangles(), from.triangles, to.triangles, vertices_, t_, *lines_, placed_);
  if (placed_.clipped_count > 0) ClipTriangles(from.triangles);
  nearest_left_ = next_clipped_ < clipped_.count     ? kAnything
                  : next_block_ < stratum_->blocks() ? stratum_->block(next_block_).nearest
                                                     : kNothingLeft;
  return true;
}

void InstantPlacer::PlaceClipped() {
  const size_t end = std::min(next_clipped_ + PlacedTriangles::kMost, clipped_.count);
  PlaceTriangles(clipped_, next_clipped_, end, vertices_, t_, *lines_, placed_);
  next_clipped_ = end;
  if (next_clipped_ < clipped_.count) return;
  nearest_left_ = next_block_ < stratum_->blocks() ? stratum_->block(next_block_).nearest : kNothingLeft;
}

void InstantPlacer::ClipTriangles(size_t first) {
  // Their corners go behind the stratum's vertices.
  size_t corners = stratum_->vertices().size();
  vertices_.Grow(corners + kMostCorners * placed_.clipped_count + kPad);
  clipped_.count = 0;
  next_clipped_ = 0;
  clipped_.Reserve(kMostPieces * placed_.clipped_count);
  const GroupTriangles& triangles = stratum_->triangles();
  const LineAxes& axes = lines_->axes;
  const size_t major = axes.major_is_x ? 0 : 1;
  for (size_t c = 0; c < placed_.clipped_count; ++c) {
    const size_t j = first + placed_.clipped[c];
    std::array<LineCorner, 3> corner;
    for (size_t i = 0; i < 3; ++i) corner[i] = stratum_->HomogeneousAt(size_t(triangles.vertex[i][j]), t_);
    const ClippedPolygon polygon = ClipTriangle(corner, stratum_->mesh().far_depth());
    if (polygon.count < 3) continue;
    for (size_t i = 0; i < size_t(polygon.count); ++i) {
      // The operations of PlaceVertices.
      const LineCorner& p = polygon.corners[i];
      const double inverse = 1 / p[3];
      const double position = p[major] * inverse;
      vertices_.row[corners + i] = p[1 - major] * inverse - axes.slope * position - axes.intercept;
      vertices_.position[corners + i] = position * double{kSubpixelsPerPixel};
      vertices_.depth[corners + i] = p[2] * inverse;
    }
    for (int i = 2; i < polygon.count; ++i) {
      clipped_.Add({.vertices = {int32_t(corners), int32_t(corners) + i - 1, int32_t(corners) + i},
                    .index = triangles.index[j],
                    .t_in = triangles.t_in[j],
                    .t_out = triangles.t_out[j],
                    .one_sided = triangles.one_sided[j]});
    }
    corners += size_t(polygon.count);
  }
  clipped_.Pad();
}

void InstantPlacer::MakePlane(uint32_t j) {
  if (planes_.size() <= j) planes_.resize(stratum_->triangles().count);
  Plane& plane = planes_[j];
  plane.instant = instant_;
  std::array<LineVertex, 3> v;
  bool is_placed = true;
  for (size_t i = 0; i < 3; ++i) {
    const auto at = size_t(stratum_->triangles().vertex[i][j]);
    v[i] = {vertices_.row[at], vertices_.position[at] / kSubpixelsPerPixel, vertices_.inverse_w[at]};
    is_placed = is_placed && std::isfinite(v[i].row);
  }
  if (is_placed) {
    // Barycentric coordinates on the plane of the lines are linear; over w they are those on the triangle.
    const double row1 = v[1].row - v[0].row, row2 = v[2].row - v[0].row;
    const double along1 = v[1].position - v[0].position, along2 = v[2].position - v[0].position;
    const double inverse = 1 / (along1 * row2 - along2 * row1);
    if (!std::isfinite(inverse)) return MakeAnywhere(plane);
    const double per_pixel1 = row2 * inverse, per_pixel2 = -row1 * inverse;
    const double per_row1 = -along2 * inverse, per_row2 = along1 * inverse;
    const double w0 = v[0].inverse_w, w1 = v[1].inverse_w, w2 = v[2].inverse_w;
    plane.per_pixel = {w1 * per_pixel1, w2 * per_pixel2, (w1 - w0) * per_pixel1 + (w2 - w0) * per_pixel2};
    plane.per_row = {w1 * per_row1, w2 * per_row2, (w1 - w0) * per_row1 + (w2 - w0) * per_row2};
    for (size_t c = 0; c < 3; ++c) {
      plane.constant[c] = -(plane.per_pixel[c] * v[0].position + plane.per_row[c] * v[0].row);
    }
    plane.constant[2] += w0;
    return;
  }
  // A corner is behind the camera. Homogeneous edge functions: with corners V_i = (X, Y, W), V_j × V_k is
  // zero along the edge jk, and over the determinant it is the barycentric coordinate of corner i over w.
  std::array<V3d, 3> corner;
  for (size_t i = 0; i < 3; ++i) {
    const auto at = stratum_->HomogeneousAt(size_t(stratum_->triangles().vertex[i][j]), t_);
    corner[i] = {at[0], at[1], at[3]};
  }
  const std::array<V3d, 3> edge{corner[1].cross(corner[2]), corner[2].cross(corner[0]),
                                corner[0].cross(corner[1])};
  const double inverse = 1 / corner[0].dot(edge[0]);
  if (!std::isfinite(inverse)) return MakeAnywhere(plane);
  const std::array<V3d, 3> over_w{edge[1] * inverse, edge[2] * inverse,
                                  (edge[0] + edge[1] + edge[2]) * inverse};
  // Along a line, minor = slope · major + (row + intercept).
  const LineAxes& axes = lines_->axes;
  for (size_t c = 0; c < 3; ++c) {
    const double per_major = axes.major_is_x ? over_w[c].x : over_w[c].y;
    plane.per_row[c] = axes.major_is_x ? over_w[c].y : over_w[c].x;
    plane.per_pixel[c] = per_major + axes.slope * plane.per_row[c];
    plane.constant[c] = plane.per_row[c] * axes.intercept + over_w[c].z;
  }
}

void InstantPlacer::MakeAnywhere(Plane& plane) {
  plane.constant = LinePosition().at;
  plane.per_row = plane.per_pixel = {0, 0, 0};
}

}  // namespace shutterline::engine
