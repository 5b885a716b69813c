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
  // Homogeneous edge functions: with corners V_i = (X, Y, W), V_j × V_k is zero along the edge jk, and over
  // the determinant it is the barycentric coordinate of corner i over w.
  std::array<V3d, 3> corner;
  for (size_t i = 0; i < 3; ++i) {
    const auto at = stratum_->HomogeneousAt(size_t(stratum_->triangles().vertex[i][j]), t_);
    corner[i] = {at[0], at[1], at[3]};
  }
  const std::array<V3d, 3> edge{corner[1].cross(corner[2]), corner[2].cross(corner[0]),
                                corner[0].cross(corner[1])};
  const double inverse = 1 / corner[0].dot(edge[0]);
  if (!std::isfinite(inverse)) {  // Seen edge-on: any place will do.
    plane.constant = LinePosition().at;
    plane.per_minor = plane.per_pixel = {0, 0, 0};
    return;
  }
  const std::array<V3d, 3> over_w{edge[1] * inverse, edge[2] * inverse,
                                  (edge[0] + edge[1] + edge[2]) * inverse};
  const LineAxes& axes = lines_->axes;
  for (size_t c = 0; c < 3; ++c) {
    const double per_major = axes.major_is_x ? over_w[c].x : over_w[c].y;
    plane.per_minor[c] = axes.major_is_x ? over_w[c].y : over_w[c].x;
    plane.per_pixel[c] = per_major + axes.slope * plane.per_minor[c];
    plane.constant[c] = over_w[c].z;
  }
}

}  // namespace shutterline::engine
