#include "worker/engine/slice/tile_strata.h"

#include <algorithm>

namespace shutterline::engine {
namespace {

/// The shutter is cut where things have moved on by about so many pixels.
constexpr double kPixelsPerStratum = 32;

}  // namespace

void TileStrata::Build(const TileMesh& mesh) {
  mesh_ = &mesh;
  for (auto* indices : {&still_indices_, &moving_indices_, &still_layer_indices_, &moving_layer_indices_}) {
    indices->clear();
  }
  motion_pixels_ = -1;
  const std::vector<TileMeshTriangle>& triangles = mesh.triangles();
  for (uint32_t i = 0; i < triangles.size(); ++i) {
    if (triangles[i].layer) {
      (triangles[i].moves ? moving_layer_indices_ : still_layer_indices_).push_back(i);
    } else {
      (triangles[i].moves ? moving_indices_ : still_indices_).push_back(i);
    }
    if (triangles[i].moves) motion_pixels_ = std::max(motion_pixels_, double(triangles[i].motion_pixels));
  }
  CountSegments();

  still_.Build(mesh, still_indices_, 0, 1);
  if (mesh.has_layers()) still_layers_.Build(mesh, still_layer_indices_, 0, 1);
  count_ = 0;
  if (!moves()) return;
  count_ = 1;
  while (double(count_) * kPixelsPerStratum < motion_pixels_) count_ *= 2;
  if (moving_.size() < count_) moving_.resize(count_);
  if (mesh.has_layers() && moving_layers_.size() < count_) moving_layers_.resize(count_);
  const double length = 1 / double(count_);
  for (size_t s = 0; s < count_; ++s) {
    const double begin = double(s) * length, end = double(s + 1) * length;
    moving_[s].Build(mesh, moving_indices_, begin, end);
    if (mesh.has_layers()) moving_layers_[s].Build(mesh, moving_layer_indices_, begin, end);
  }
}

size_t TileStrata::NumberAt(double t) const {
  return std::min(count_ - 1, size_t(t * double(count_)));
}

void TileStrata::CountSegments() {
  // A triangle's extent across the lines tells how many of them it meets, its share of the shutter how often.
  const std::array<double, 2> breadth{double(mesh_->rect().height), double(mesh_->rect().width)};
  for (size_t f = 0; f < 2; ++f) {
    double segments = 0;
    for (const TileMeshTriangle& triangle : mesh_->triangles()) {
      const double rows = std::min(triangle.row_high[f], breadth[f]) - std::max(triangle.row_low[f], 0.0);
      const double share = triangle.moves ? std::clamp(triangle.t_out - triangle.t_in, 0.0, 1.0) : 1;
      segments += std::clamp(rows, 0.5, breadth[f]) * share;
    }
    segments_per_line_[f] = segments / breadth[f];
  }
}

}  // namespace shutterline::engine
