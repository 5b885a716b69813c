#include "worker/engine/slice/stratum.h"

#include <algorithm>

namespace shutterline::engine {
namespace {

constexpr int32_t kNoPlace = -1;

}  // namespace

void Stratum::Build(const TileMesh& mesh, std::span<const uint32_t> indices, double begin, double end) {
  mesh_ = &mesh;
  GatherTriangles(indices, begin, end);

  vertices_.linear = straight_.size();
  vertices_.curved = curved_.size();
  // Curved vertices come after the straight ones.
  if (!curved_.empty()) {
    const auto first_curved = int32_t(vertices_.first_curved());
    for (auto& corner : triangles_.vertex) {
      for (size_t j = 0; j < triangles_.count; ++j) {
        if (corner[j] < 0) corner[j] = first_curved - 2 - corner[j];
      }
    }
  }
  triangles_.Pad();

  const size_t size = vertices_.size();
  for (size_t k = 0; k < (curved_.empty() ? 2u : 4u); ++k) {
    for (auto& coordinate : vertices_.power[k]) {
      if (coordinate.size() < size) coordinate.resize(size);
    }
  }
  vertices_.time_scale.assign(Padded(curved_.size()), 0);
  vertices_.time_offset.assign(Padded(curved_.size()), 0);
  const auto load = [&](size_t k, size_t i, const RasterPoint& p) {
    auto& power = vertices_.power[k];
    power[0][i] = p.x;
    power[1][i] = p.y;
    power[2][i] = p.z;
    power[3][i] = p.w;
  };
  for (size_t i = 0; i < straight_.size(); ++i) {
    const TileVertex& vertex = mesh.vertices()[straight_[i]];
    load(0, i, vertex.open);
    load(1, i, vertex.close - vertex.open);
  }
  piece_begin_ = curved_.empty() ? -std::numeric_limits<double>::infinity() : 0;
  piece_end_ = curved_.empty() ? std::numeric_limits<double>::infinity() : 0;
}

void Stratum::GatherTriangles(std::span<const uint32_t> indices, double begin, double end) {
  // Number vertices as they come: a block then needs a run of them.
  triangles_.count = 0;
  triangles_.Reserve(indices.size());
  straight_.clear();
  curved_.clear();
  blocks_.clear();
  place_of_.assign(mesh_->vertices().size(), kNoPlace);
  if (number_of_.size() < mesh_->triangles().size()) number_of_.resize(mesh_->triangles().size());
  const auto end_block = [&] {
    if (blocks_.empty()) return;
    blocks_.back().triangles = triangles_.count;
    blocks_.back().straight = straight_.size();
    blocks_.back().curved = curved_.size();
  };
  for (const uint32_t index : indices) {
    const TileMeshTriangle& source = mesh_->triangles()[index];
    if (source.t_in > end || source.t_out < begin) continue;
    if (triangles_.count % PlacedTriangles::kMost == 0) {
      end_block();
      blocks_.push_back({.nearest = source.nearest});
    }
    GroupTriangle triangle{.index = index,
                           .t_in = source.t_in,
                           .t_out = source.t_out,
                           .one_sided = source.cull_back ? 1.0 : 0.0};
    for (size_t i = 0; i < 3; ++i) {
      const uint32_t vertex = source.vertices[i];
      int32_t& place = place_of_[vertex];
      if (place == kNoPlace) {
        const bool curved = mesh_->vertices()[vertex].curved;
        place = curved ? -2 - int32_t(curved_.size()) : int32_t(straight_.size());
        (curved ? curved_ : straight_).push_back(vertex);
      }
      triangle.vertices[i] = place;
    }
    number_of_[index] = uint32_t(triangles_.count);
    triangles_.Add(triangle);
  }
  end_block();
}

void Stratum::LoadPieces(double t) {
  const size_t first = vertices_.first_curved();
  piece_begin_ = -std::numeric_limits<double>::infinity();
  piece_end_ = std::numeric_limits<double>::infinity();
  for (size_t i = 0; i < curved_.size(); ++i) {
    const TileVertex& vertex = mesh_->vertices()[curved_[i]];
    const TileMesh::Power power = mesh_->PowerAt(vertex, t);
    for (size_t k = 0; k < 4; ++k) {
      const RasterPoint& p = power.coefficients[k];
      vertices_.power[k][0][first + i] = p.x;
      vertices_.power[k][1][first + i] = p.y;
      vertices_.power[k][2][first + i] = p.z;
      vertices_.power[k][3][first + i] = p.w;
    }
    vertices_.time_scale[i] = power.time_scale;
    vertices_.time_offset[i] = power.time_offset;
    const FramePrimitive& primitive = mesh_->frame().primitives[vertex.primitive];
    const int piece = primitive.PositionAt(t).piece;
    if (piece > 0) piece_begin_ = std::max(piece_begin_, double(piece) / primitive.pieces);
    if (piece + 1 < primitive.pieces) {
      piece_end_ = std::min(piece_end_, double(piece + 1) / primitive.pieces);
    }
  }
}

std::array<double, kRasterCoordinates> Stratum::HomogeneousAt(size_t at, double t) const {
  const auto& power = vertices_.power;
  std::array<double, kRasterCoordinates> value;
  for (size_t c = 0; c < kRasterCoordinates; ++c) {
    if (at < vertices_.first_curved()) {
      value[c] = power[0][c][at] + t * power[1][c][at];
      continue;
    }
    const size_t k = at - vertices_.first_curved();
    const double tau = t * vertices_.time_scale[k] + vertices_.time_offset[k];
    value[c] = power[3][c][at];
    for (size_t p = 3; p-- > 0;) value[c] = power[p][c][at] + tau * value[c];
  }
  return value;
}

}  // namespace shutterline::engine
