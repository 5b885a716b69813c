#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "worker/engine/slice/stratum.h"
#include "worker/engine/slice/tile_mesh.h"

namespace shutterline::engine {

/// A tile's triangles by when they may be seen: those that stand still, and those that move, in equal parts
/// of the shutter, in each of which things have moved on by a few pixels: what is in the tile for a short
/// while is looked at for a short while only, which keeps the price linear in the length of the motion.
/// Shared by all classes of lines. Keeps its memory.
class TileStrata {
 public:
  void Build(const TileMesh& mesh);

  const TileMesh& mesh() const { return *mesh_; }
  /// Does anything move?
  bool moves() const { return motion_pixels_ >= 0; }
  /// How far things move, by the longest path of a vertex, pixels. Negative where nothing does.
  double motion_pixels() const { return motion_pixels_; }

  Stratum& still() { return still_; }
  /// Layers are apart from what is opaque: they hide nothing.
  Stratum& still_layers() { return still_layers_; }
  /// The part of the shutter that holds t.
  Stratum& At(double t) { return moving_[NumberAt(t)]; }
  Stratum& LayersAt(double t) { return moving_layers_[NumberAt(t)]; }

  /// About how many segments a line of a family gets at an instant, hidden ones included.
  double SegmentsPerLine(size_t family) const { return segments_per_line_[family]; }

 private:
  void CountSegments();
  size_t NumberAt(double t) const;

  const TileMesh* mesh_ = nullptr;
  double motion_pixels_ = -1;
  std::array<double, 2> segments_per_line_{};
  Stratum still_, still_layers_;
  std::vector<Stratum> moving_, moving_layers_;
  size_t count_ = 0;  // Of moving_ that are in use.
  std::vector<uint32_t> still_indices_, moving_indices_, still_layer_indices_, moving_layer_indices_;
};

}  // namespace shutterline::engine
