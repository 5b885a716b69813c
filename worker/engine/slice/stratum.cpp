#include "worker/engine/slice/stratum.h"

#include <algorithm>
#include <cmath>

#include "common/math/tolerance.h"
#include "worker/engine/slice/near_clip.h"

namespace shutterline::engine {
namespace {

/// Triangles that are cut give at most three, from five corners.
constexpr size_t kMostCorners = 5;

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

  // Gather triangles, and number their vertices: straight ones first.
  triangles_.Clear();
  numbering_.Reset(3 * indices.size());
  mesh_vertex_.clear();
  if (triangle_of_.size() < mesh.triangles().size()) triangle_of_.resize(mesh.triangles().size());
  for (const uint32_t index : indices) {
    const TileMeshTriangle& triangle = mesh.triangles()[index];
    if (triangle.t_in > end || triangle.t_out < begin) continue;
    std::array<int32_t, 3> numbers;
    for (size_t i = 0; i < 3; ++i) {
      bool is_new = false;
      numbers[i] = int32_t(numbering_.NumberOf(triangle.vertices[i], is_new));
      if (is_new) mesh_vertex_.push_back(triangle.vertices[i]);
    }
    triangle_of_[index] = uint32_t(triangles_.count);
    triangles_.Add(numbers, index, triangle.id, triangle.t_in, triangle.t_out, FacingOf(triangle, group));
  }
  slot_.resize(mesh_vertex_.size());
  size_t straight = 0;
  curved_.clear();
  for (size_t i = 0; i < mesh_vertex_.size(); ++i) {
    if (!mesh.vertices()[mesh_vertex_[i]].curved) slot_[i] = int32_t(straight++);
  }
  const size_t first_curved = Padded(straight);
  for (size_t i = 0; i < mesh_vertex_.size(); ++i) {
    if (!mesh.vertices()[mesh_vertex_[i]].curved) continue;
    slot_[i] = int32_t(first_curved + curved_.size());
    curved_.push_back(mesh_vertex_[i]);
  }
  vertices_.linear = straight;
  vertices_.count = straight + curved_.size();
  const size_t size = first_curved + Padded(curved_.size());
  for (size_t k = 0; k < 4; ++k) {
    if (k >= 2 && curved_.empty()) break;
    for (auto& coordinate : vertices_.power[k]) {
      if (coordinate.size() < size) coordinate.resize(size);
    }
  }
  vertices_.time_scale.assign(Padded(curved_.size()), 0);
  vertices_.time_offset.assign(Padded(curved_.size()), 0);
  for (size_t i = 0; i < mesh_vertex_.size(); ++i) {
    const TileVertex& vertex = mesh.vertices()[mesh_vertex_[i]];
    if (!vertex.curved) LoadVertex(size_t(slot_[i]), vertex, 0, false);
  }
  next_piece_at_ = curved_.empty() ? 2 : -1;
  for (auto& corner : triangles_.vertex) {
    for (int32_t& v : corner) v = slot_[size_t(v)];
  }
  triangles_.Pad();
  placed_.Resize(Padded(triangles_.count));
  if (placed_vertices_.size() < size + kPad) placed_vertices_.Resize(size + kPad);
}

void Stratum::LoadVertex(size_t at, const TileVertex& vertex, double t, bool curved) {
  const TileMesh::Power power = mesh_->PowerAt(vertex, t);
  for (size_t k = 0; k < (curved ? 4u : 2u); ++k) {
    const RasterPoint& p = power.coefficients[k];
    const double major = group_->major_is_x ? p.x : p.y;
    const double minor = group_->major_is_x ? p.y : p.x;
    vertices_.power[k][0][at] = minor - group_->slope * major - group_->intercept * p.w;
    vertices_.power[k][1][at] = major;
    vertices_.power[k][2][at] = p.z;
    vertices_.power[k][3][at] = p.w;
  }
  if (!curved) return;
  vertices_.time_scale[at - Padded(vertices_.linear)] = power.time_scale;
  vertices_.time_offset[at - Padded(vertices_.linear)] = power.time_offset;
}

void Stratum::LoadPieces(double t) {
  const size_t first = Padded(vertices_.linear);
  next_piece_at_ = 2;
  for (size_t i = 0; i < curved_.size(); ++i) {
    const TileVertex& vertex = mesh_->vertices()[curved_[i]];
    LoadVertex(first + i, vertex, t, true);
    const FramePrimitive& primitive = mesh_->frame().primitives[vertex.primitive];
    next_piece_at_ = std::min(next_piece_at_, (primitive.PositionAt(t).piece + 1.0) / primitive.pieces);
  }
}

void Stratum::Place(double t) {
  if (t >= next_piece_at_) LoadPieces(t);
  PlaceVertices(vertices_, t, mesh_->far_depth(), placed_vertices_);
  PlaceTriangles(triangles_, placed_vertices_, t, group_->lanes, length_, placed_);
  ClipTriangles(t);
}

void Stratum::ClipTriangles(double t) {
  clipped_.Clear();
  size_t corners = Padded(vertices_.linear) + Padded(curved_.size());
  const size_t first_corner = corners;
  for (size_t j = 0; j < triangles_.count; ++j) {
    if (placed_.clipped[j] == 0) continue;
    std::array<LineCorner, 3> corner;
    for (size_t i = 0; i < 3; ++i) {
      for (size_t c = 0; c < 4; ++c) {
        corner[i][c] = placed_vertices_.homogeneous[c][size_t(triangles_.vertex[i][j])];
      }
    }
    const ClippedPolygon polygon = ClipTriangle(corner, mesh_->far_depth());
    if (polygon.count < 3) continue;
    if (placed_vertices_.size() < corners + kMostCorners + kPad) {
      placed_vertices_.Resize(2 * (corners + kMostCorners + kPad));
    }
    for (int i = 0; i < polygon.count; ++i) {
      for (size_t c = 0; c < 4; ++c) {
        placed_vertices_.homogeneous[c][corners + size_t(i)] = polygon.corners[size_t(i)][c];
      }
    }
    for (int i = 2; i < polygon.count; ++i) {
      clipped_.Add({int32_t(corners), int32_t(corners) + i - 1, int32_t(corners) + i}, triangles_.index[j],
                   triangles_.id[j], triangles_.t_in[j], triangles_.t_out[j], triangles_.facing[j]);
    }
    corners += size_t(polygon.count);
  }
  if (clipped_.count == 0) return;
  clipped_.Pad();
  clipped_placed_.Resize(Padded(clipped_.count));
  ProjectVertices(first_corner, corners, placed_vertices_);
  PlaceTriangles(clipped_, placed_vertices_, t, group_->lanes, length_, clipped_placed_);
}

LinePosition Stratum::PositionOn(uint32_t index, int lane) const {
  const uint32_t j = triangle_of_[index];
  // Homogeneous edge functions: with corners V_i = (row w, position w, w), V_j × V_k is zero along the edge
  // jk, and over the determinant it is the barycentric coordinate of corner i over w.
  std::array<V3d, 3> corner;
  for (size_t i = 0; i < 3; ++i) {
    const auto v = size_t(triangles_.vertex[i][j]);
    corner[i] = {placed_vertices_.homogeneous[0][v], placed_vertices_.homogeneous[1][v],
                 placed_vertices_.homogeneous[3][v]};
  }
  const std::array<V3d, 3> edge{corner[1].cross(corner[2]), corner[2].cross(corner[0]),
                                corner[0].cross(corner[1])};
  const double inverse = 1 / corner[0].dot(edge[0]);
  LinePosition position;
  if (!std::isfinite(inverse)) return position;  // Edge-on: any place will do.
  const V3d sum = edge[0] + edge[1] + edge[2];
  const std::array<V3d, 3> wanted{edge[1], edge[2], sum};
  for (size_t c = 0; c < 3; ++c) {
    position.at[c] = (wanted[c].x * lane + wanted[c].z) * inverse;
    position.per_pixel[c] = wanted[c].y * inverse;
  }
  return position;
}

}  // namespace shutterline::engine
