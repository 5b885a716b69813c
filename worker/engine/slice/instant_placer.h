#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/math/spaces.h"
#include "worker/engine/slice/kernels.h"
#include "worker/engine/slice/stratum.h"
#include "worker/engine/visibility/line_position.h"

namespace shutterline::engine {

/// Places a stratum's triangles at an instant, for all lines of a class, block by block and nearest first.
/// Keeps its memory.
class InstantPlacer {
 public:
  /// Moves on to shutter time t, which lies within the stratum.
  void Begin(Stratum& stratum, const LineClass& lines, double t);

  /// Bound on the depth of everything that has not been placed yet; negative infinity if nothing is left.
  float nearest_left() const { return nearest_left_; }

  /// Places the next triangles. False if there are none left. What is left of triangles that cross the near
  /// or the far plane follows their block.
  bool PlaceNext();
  const PlacedTriangles& placed() const { return placed_; }

  /// Where on triangle `index` of the mesh, one of the stratum's, the points of row `row` lie.
  LinePosition PositionOn(uint32_t index, int row) {
    const uint32_t j = stratum_->NumberOf(index);
    if (j >= planes_.size() || planes_[j].instant != instant_) MakePlane(j);
    const Plane& plane = planes_[j];
    LinePosition position;
    for (size_t c = 0; c < 3; ++c) position.at[c] = plane.per_row[c] * row + plane.constant[c];
    position.per_pixel = plane.per_pixel;
    return position;
  }

 private:
  void PlaceClipped();
  void ClipTriangles(size_t first);

  Stratum* stratum_ = nullptr;
  const LineClass* lines_ = nullptr;
  double t_ = 0;
  size_t next_block_ = 0;
  size_t next_clipped_ = 0;  // Of clipped_.
  float nearest_left_ = 0;

  PlacedVertices vertices_;
  GroupTriangles clipped_;
  PlacedTriangles placed_;

  /// Positions on a triangle along the lines, at the instant with number `instant`: b1, b2 and their sum with
  /// b0, over w.
  struct Plane {
    int64_t instant = -1;
    std::array<double, 3> per_row{}, constant{}, per_pixel{};
  };
  void MakePlane(uint32_t j);
  /// Where a triangle is seen edge-on, any place on it will do.
  static void MakeAnywhere(Plane& plane);

  std::vector<Plane> planes_;  // By the stratum's number of the triangle.
  int64_t instant_ = 0;
};

}  // namespace shutterline::engine
