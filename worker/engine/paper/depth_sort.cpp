#include "worker/engine/paper/depth_sort.h"

#include <algorithm>
#include <cmath>

#include "common/math/tolerance.h"

namespace shutterline::engine::paper {

void DepthSort::Insert(const CellPolygon& polygon, PolygonArena& arena) {
  if (nodes_.empty()) {
    nodes_.push_back({polygon});
    return;
  }
  pending_.clear();
  pending_.push_back({polygon, 0});
  while (!pending_.empty()) {
    Pending next = pending_.back();
    pending_.pop_back();
    const CellPolygon& at = nodes_[next.node].polygon;

    // Planes are subtracted before they are evaluated: equal planes differ by exactly nothing.
    const HalfPlane nearer{next.polygon.plane.du - at.plane.du, next.polygon.plane.dv - at.plane.dv,
                           next.polygon.plane.d - at.plane.d};
    const double tolerance = kEqualDepth * (std::abs(next.polygon.plane.d) + std::abs(at.plane.d) +
                                            std::abs(at.plane.du) + std::abs(at.plane.dv));
    const PolygonSplit split = arena.Split(next.polygon.polygon, nearer, tolerance);
    const auto go = [&](bool to_front, const Polygon& part) {
      CellPolygon piece = next.polygon;
      piece.polygon = part;
      Node& node = nodes_[next.node];
      uint32_t& child = to_front ? node.front : node.back;
      if (child != kNone) {
        pending_.push_back({piece, child});
      } else {
        child = uint32_t(nodes_.size());
        nodes_.push_back({piece});  // `node` and `child` are gone after this.
      }
    };
    if (split.all_on) {
      go(next.polygon.id < at.id, next.polygon.polygon);
      continue;
    }
    if (split.positive.count != 0) go(true, split.positive);
    if (split.negative.count != 0) go(false, split.negative);
  }
}

}  // namespace shutterline::engine::paper
