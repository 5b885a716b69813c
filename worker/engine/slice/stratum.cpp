#include "worker/engine/slice/stratum.h"

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

/// The sign that the area of a triangle seen from the front has in (row, position). Raster y points down,
/// which makes counter-clockwise triangles turn the other way, and exchanging the axes turns them again.
double FacingOf(const TileMeshTriangle& triangle, const LineGroup& group) {
  if (!triangle.cull_back) return 0;
  return group.major_is_x ? 1 : -1;
}

}  // namespace

void Stratum::Build(const TileMesh& mesh, const LineGroup& group, std::span<const uint32_t> indices,
                    double begin, double end) {
  mesh_ = &mesh;
  group_ = &group;
  length_ = (group.major_is_x ? mesh.rect().width : mesh.rect().height) * kSubpixelsPerPixel;

  // Gather triangles, and number their vertices as they come: a block then needs a run of them.
  triangles_.count = 0;
  triangles_.Reserve(indices.size());
  numbering_.Reset(3 * indices.size());
  slot_.clear();
  straight_.clear();
  curved_.clear();
  blocks_.clear();
  if (triangle_of_.size() < mesh.triangles().size()) triangle_of_.resize(mesh.triangles().size());
  const auto end_block = [&] {
    if (!blocks_.empty()) {
      blocks_.back().triangles = triangles_.count;
      blocks_.back().straight = straight_.size();
      blocks_.back().curved = curved_.size();
    }
  };
  for (const uint32_t index : indices) {
    const TileMeshTriangle& source = mesh.triangles()[index];
    if (source.t_in > end || source.t_out < begin) continue;
    if (triangles_.count % kBlock == 0) {
      end_block();
      blocks_.push_back({.nearest = source.nearest});
    }
    GroupTriangle triangle{
        .index = index, .t_in = source.t_in, .t_out = source.t_out, .facing = FacingOf(source, group)};
    for (size_t i = 0; i < 3; ++i) {
      bool is_new = false;
      const uint32_t number = numbering_.NumberOf(source.vertices[i], is_new);
      if (is_new) {
        const bool curved = mesh.vertices()[source.vertices[i]].curved;
        slot_.push_back(curved ? -1 - int32_t(curved_.size()) : int32_t(straight_.size()));
        (curved ? curved_ : straight_).push_back(source.vertices[i]);
      }
      triangle.vertices[i] = slot_[number];
    }
    triangle_of_[index] = uint32_t(triangles_.count);
    triangles_.Add(triangle);
  }
  end_block();
  if (!blocks_.empty()) {
    Block last = blocks_.back();
    last.nearest = -std::numeric_limits<float>::infinity();
    blocks_.push_back(last);
  }

  // Curved vertices come after the straight ones.
  const size_t first_curved = Padded(straight_.size());
  if (!curved_.empty()) {
    for (auto& corner : triangles_.vertex) {
      for (size_t j = 0; j < triangles_.count; ++j) {
        if (corner[j] < 0) corner[j] = int32_t(first_curved) - 1 - corner[j];
      }
    }
  }
  triangles_.Pad();
  const size_t size = first_curved + Padded(curved_.size());
  vertices_.linear = straight_.size();
  vertices_.count = straight_.size() + curved_.size();
  for (size_t k = 0; k < (curved_.empty() ? 2u : 4u); ++k) {
    for (auto& coordinate : vertices_.power[k]) {
      if (coordinate.size() < size) coordinate.resize(size);
    }
  }
  vertices_.time_scale.assign(Padded(curved_.size()), 0);
  vertices_.time_offset.assign(Padded(curved_.size()), 0);
  for (size_t i = 0; i < straight_.size(); ++i) LoadStraight(i, mesh.vertices()[straight_[i]]);
  next_piece_at_ = curved_.empty() ? 2 : -1;
  placed_.Resize(Padded(triangles_.count));
  planes_.assign(triangles_.count, {});
  if (placed_vertices_.size() < size + kPad) placed_vertices_.Resize(size + kPad);
}

void Stratum::LoadStraight(size_t at, const TileVertex& vertex) {
  const auto load = [&](size_t k, const RasterPoint& p) {
    const double major = group_->major_is_x ? p.x : p.y;
    const double minor = group_->major_is_x ? p.y : p.x;
    auto& power = vertices_.power[k];
    power[0][at] = minor - group_->slope * major - group_->intercept * p.w;
    power[1][at] = major;
    power[2][at] = p.z;
    power[3][at] = p.w;
  };
  load(0, vertex.open);
  load(1, vertex.close - vertex.open);
}

void Stratum::LoadPieces() {
  const size_t first = Padded(vertices_.linear);
  next_piece_at_ = 2;
  for (size_t i = 0; i < curved_.size(); ++i) {
    const TileVertex& vertex = mesh_->vertices()[curved_[i]];
    const TileMesh::Power power = mesh_->PowerAt(vertex, t_);
    for (size_t k = 0; k < 4; ++k) {
      const RasterPoint& p = power.coefficients[k];
      const double major = group_->major_is_x ? p.x : p.y;
      const double minor = group_->major_is_x ? p.y : p.x;
      vertices_.power[k][0][first + i] = minor - group_->slope * major - group_->intercept * p.w;
      vertices_.power[k][1][first + i] = major;
      vertices_.power[k][2][first + i] = p.z;
      vertices_.power[k][3][first + i] = p.w;
    }
    vertices_.time_scale[i] = power.time_scale;
    vertices_.time_offset[i] = power.time_offset;
    const FramePrimitive& primitive = mesh_->frame().primitives[vertex.primitive];
    next_piece_at_ = std::min(next_piece_at_, (primitive.PositionAt(t_).piece + 1.0) / primitive.pieces);
  }
}

void Stratum::BeginInstant(double t) {
  t_ = t;
  ++instant_;
  next_block_ = 0;
  if (t >= next_piece_at_) LoadPieces();
}

bool Stratum::PlaceNextBlock() {
  if (next_block_ + 1 >= blocks_.size()) return false;
  const Block from = next_block_ == 0 ? Block{} : blocks_[next_block_ - 1];
  const Block& to = blocks_[next_block_++];
  const double far_depth = mesh_->far_depth();
  // Whole vectors: a few are placed twice.
  const size_t straight = from.straight / kPad * kPad;
  PlaceVertices(vertices_, straight, to.straight, false, t_, far_depth, placed_vertices_);
  if (to.curved > from.curved) {
    const size_t first = Padded(vertices_.linear);
    PlaceVertices(vertices_, first + from.curved / kPad * kPad, first + to.curved, true, t_, far_depth,
                  placed_vertices_);
  }
  PlaceTriangles(triangles_, from.triangles, to.triangles, placed_vertices_, t_, group_->lanes, length_,
                 placed_);
  clipped_.count = 0;
  if (!placed_.clipped.empty()) ClipTriangles();
  return true;
}

std::array<double, kLineCoordinates> Stratum::HomogeneousAt(size_t at) const {
  // The operations of PlaceVertices.
  const auto& power = vertices_.power;
  std::array<double, kLineCoordinates> value;
  const size_t first_curved = Padded(vertices_.linear);
  for (size_t c = 0; c < kLineCoordinates; ++c) {
    if (at < first_curved) {
      value[c] = power[0][c][at] + t_ * power[1][c][at];
      continue;
    }
    const size_t k = at - first_curved;
    const double tau = t_ * vertices_.time_scale[k] + vertices_.time_offset[k];
    value[c] = power[3][c][at];
    for (size_t p = 3; p-- > 0;) value[c] = power[p][c][at] + tau * value[c];
  }
  return value;
}

void Stratum::ClipTriangles() {
  size_t corners = Padded(vertices_.linear) + Padded(curved_.size());
  clipped_.Reserve(kMostPieces * placed_.clipped.size());
  for (const uint32_t j : placed_.clipped) {
    std::array<LineCorner, 3> corner;
    for (size_t i = 0; i < 3; ++i) corner[i] = HomogeneousAt(size_t(triangles_.vertex[i][j]));
    const ClippedPolygon polygon = ClipTriangle(corner, mesh_->far_depth());
    if (polygon.count < 3) continue;
    if (placed_vertices_.size() < corners + kMostCorners) {
      placed_vertices_.Resize(2 * (corners + kMostCorners));
    }
    for (size_t i = 0; i < size_t(polygon.count); ++i) {
      // The operations of PlaceVertices.
      const double inverse = 1 / polygon.corners[i][3];
      placed_vertices_.row[corners + i] = polygon.corners[i][0] * inverse;
      placed_vertices_.position[corners + i] = polygon.corners[i][1] * inverse * double{kSubpixelsPerPixel};
      placed_vertices_.depth[corners + i] = polygon.corners[i][2] * inverse;
    }
    for (int i = 2; i < polygon.count; ++i) {
      clipped_.Add({.vertices = {int32_t(corners), int32_t(corners) + i - 1, int32_t(corners) + i},
                    .index = triangles_.index[j],
                    .t_in = triangles_.t_in[j],
                    .t_out = triangles_.t_out[j],
                    .facing = triangles_.facing[j]});
    }
    corners += size_t(polygon.count);
  }
  clipped_.Pad();
  clipped_placed_.Resize(Padded(clipped_.count));
  PlaceTriangles(clipped_, 0, clipped_.count, placed_vertices_, t_, group_->lanes, length_, clipped_placed_);
}

LinePosition Stratum::PositionOn(uint32_t index, int lane) {
  const uint32_t j = triangle_of_[index];
  Plane& plane = planes_[j];
  if (plane.instant != instant_) {
    plane.instant = instant_;
    // Homogeneous edge functions: with corners V_i = (row w, position w, w), V_j × V_k is zero along the edge
    // jk, and over the determinant it is the barycentric coordinate of corner i over w.
    std::array<V3d, 3> corner;
    for (size_t i = 0; i < 3; ++i) {
      const auto at = HomogeneousAt(size_t(triangles_.vertex[i][j]));
      corner[i] = {at[0], at[1], at[3]};
    }
    const std::array<V3d, 3> edge{corner[1].cross(corner[2]), corner[2].cross(corner[0]),
                                  corner[0].cross(corner[1])};
    const double inverse = 1 / corner[0].dot(edge[0]);
    plane.edge_on = !std::isfinite(inverse);
    plane.over_w = {edge[1] * inverse, edge[2] * inverse, (edge[0] + edge[1] + edge[2]) * inverse};
  }
  LinePosition position;
  if (plane.edge_on) return position;  // Any place will do.
  for (size_t c = 0; c < 3; ++c) {
    position.at[c] = plane.over_w[c].x * lane + plane.over_w[c].z;
    position.per_pixel[c] = plane.over_w[c].y;
  }
  return position;
}

}  // namespace shutterline::engine
