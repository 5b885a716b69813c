#include "worker/engine/slice/tile_mesh.h"

#include <algorithm>
#include <bit>

#include "common/math/tolerance.h"
#include "worker/engine/slice/moving_vertices.h"

namespace shutterline::engine {
namespace {

/// So many elements ahead memory is fetched.
constexpr size_t kAhead = 8;

/// A texture that moves under a pixel is blurred by shading it at several times; what varies linearly
/// over a triangle (vertex colours) or slowly (a head light) is exact or good at one mean position.
uint8_t ShadingBinsLog2(bool textured, double motion_pixels) {
  constexpr int kMost = 6;
  if (!textured) return 0;
  int log2 = 0;
  while (log2 < kMost && double(1 << log2) < motion_pixels) ++log2;
  return uint8_t(log2);
}

/// The next float above x >= 0.
float RoundedUp(double x) {
  return std::bit_cast<float>(std::bit_cast<uint32_t>(float(x)) + 1);
}

RasterPoint RelativeTo(const TileRect& rect, const RasterPoint& p) {
  return {p.x - rect.x * p.w, p.y - rect.y * p.w, p.z, p.w};
}

}  // namespace

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
  NumberVertices(input.candidates);
  MakeVertices(TileVertexMaker(input.frame, input.rect, pattern));
  unsorted_.clear();
  places_.clear();
  has_layers_ = false;
  for (size_t i = 0; i < input.candidates.size(); ++i) {
    AddTriangle(input.candidates[i], corners_[i], input.traits[met_[corners_[i][0]].primitive]);
  }
  SortTriangles();
}

void TileMesh::NumberVertices(std::span<const uint32_t> candidates) {
  uint32_t count = 0;
  for (const FramePrimitive& primitive : frame_->primitives) {
    count = std::max(count, primitive.first_vertex + primitive.vertex_count);
  }
  if (numbers_.size() < count) numbers_.resize(count);
  if (++generation_ == 0) {
    std::fill(numbers_.begin(), numbers_.end(), 0);
    generation_ = 1;
  }
  met_.clear();
  corners_.resize(candidates.size());
  for (size_t i = 0; i < candidates.size(); ++i) {
    if (i + 2 * kAhead < candidates.size()) {
      __builtin_prefetch(&frame_->triangles[candidates[i + 2 * kAhead]]);
      for (const uint32_t vertex : frame_->triangles[candidates[i + kAhead]].vertices) {
        __builtin_prefetch(&numbers_[vertex], 1);
      }
    }
    const FrameTriangle& triangle = frame_->triangles[candidates[i]];
    for (size_t k = 0; k < 3; ++k) {
      uint64_t& number = numbers_[triangle.vertices[k]];
      if (number >> 32 != generation_) {
        number = uint64_t{generation_} << 32 | met_.size();
        met_.push_back({triangle.vertices[k], triangle.primitive});
      }
      corners_[i][k] = uint32_t(number);
    }
  }
}

void TileMesh::MakeVertices(const TileVertexMaker& maker) {
  vertices_.clear();
  vertices_.resize(met_.size());
  for (size_t i = 0; i < met_.size(); ++i) {
    if (i + kAhead < met_.size()) {
      const Met& ahead = met_[i + kAhead];
      const FramePrimitive& primitive = frame_->primitives[ahead.primitive];
      const RasterPoint* points = frame_->ControlPoints(primitive, ahead.vertex);
      __builtin_prefetch(points);
      __builtin_prefetch(points + primitive.PointsPerVertex() - 1);
    }
    maker.Make(met_[i].primitive, met_[i].vertex, vertices_[i]);
  }
}

void TileMesh::AddTriangle(uint32_t id, const std::array<uint32_t, 3>& numbers,
                           const PrimitiveTraits& traits) {
  const TileVertex& a = vertices_[numbers[0]];
  const TileVertex& b = vertices_[numbers[1]];
  const TileVertex& c = vertices_[numbers[2]];

  // It is inside while some vertex is inside of each plane.
  float t_in = 0;
  float t_out = 1;
  if (!(a.always_inside || b.always_inside || c.always_inside)) {
    for (size_t p = 0; p < TileVertex::kPlanes; ++p) {
      t_in = std::max(t_in, std::min({a.in[p], b.in[p], c.in[p]}));
      t_out = std::min(t_out, std::max({a.out[p], b.out[p], c.out[p]}));
    }
    if (t_in > t_out) return;
  }

  TileMeshTriangle& triangle = unsorted_.emplace_back();
  triangle.id = id;
  triangle.vertices = numbers;
  triangle.moves = a.moves || b.moves || c.moves;
  triangle.cull_back = traits.cull_back;
  triangle.needs_position = traits.needs_position;
  triangle.layer = traits.layer;
  triangle.layer_alpha = traits.layer_alpha;
  triangle.alpha_cutoff = traits.alpha_cutoff;
  has_layers_ = has_layers_ || traits.layer;
  triangle.nearest = RoundedUp(std::max({a.nearest, b.nearest, c.nearest})) * kFloatDepthSlack;
  const double motion = std::max({a.motion_pixels, b.motion_pixels, c.motion_pixels});
  triangle.motion_pixels = RoundedUp(motion);
  if (triangle.moves) triangle.shading_bins_log2 = ShadingBinsLog2(traits.textured, motion);
  triangle.t_in = double(t_in);
  triangle.t_out = double(t_out);
  for (size_t f = 0; f < 2; ++f) {
    triangle.row_low[f] = std::min({a.row_low[f], b.row_low[f], c.row_low[f]});
    triangle.row_high[f] = std::max({a.row_high[f], b.row_high[f], c.row_high[f]});
  }
  // Floats that are not negative are ordered as their bits are.
  const uint32_t farness = ~std::bit_cast<uint32_t>(triangle.nearest);
  places_.push_back({uint64_t{farness} << 32 | id, uint32_t(unsorted_.size() - 1)});
}

void TileMesh::SortTriangles() {
  std::sort(places_.begin(), places_.end(), [](const Place& a, const Place& b) { return a.key < b.key; });
  triangles_.clear();
  ids_.clear();
  for (const Place& place : places_) {
    triangles_.push_back(unsorted_[place.triangle]);
    ids_.push_back(triangles_.back().id);
  }
  ids_.resize(Padded(ids_.size()));
}

}  // namespace shutterline::engine
