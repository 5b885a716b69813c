#pragma once

#include <cstdint>
#include <vector>

#include "worker/engine/paper/polygon.h"

namespace shutterline::engine::paper {

/// Depth over a cell: d + du·u + dv·v.
struct CellPlane {
  double d = 0, du = 0, dv = 0;
  double At(const CellPoint& p) const { return d + du * p.u + dv * p.v; }
};

/// A patch piece within a cell.
struct CellPolygon {
  Polygon polygon;
  CellPlane plane;
  double nearest = 0, farthest = 0;  ///< Depths over the polygon.
  uint32_t index = 0;                ///< Of the triangle in TileTriangles.
  uint32_t id = 0;                   ///< The triangle's.
};

/// Orders a cell's polygons front to back in a BSP tree over their planes [gribel2011, section 5.2; Fuchs
/// et al. 1980], splitting those that intersect. As all are looked at along the depth axis, a plane's
/// front side is where depth is larger than the plane's, and a split is a cut of the polygon in (u, v) by
/// the line where the two depths are equal. Where they are equal all over, the lower id is in front.
class DepthSort {
 public:
  void Clear() { nodes_.clear(); }

  void Insert(const CellPolygon& polygon, PolygonArena& arena);

  /// Calls visit(const CellPolygon&) front to back until it returns false.
  template <typename Visit>
  void FrontToBack(const Visit& visit);

  size_t size() const { return nodes_.size(); }

 private:
  static constexpr uint32_t kNone = ~uint32_t{0};
  struct Node {
    CellPolygon polygon;
    uint32_t front = kNone, back = kNone;
  };
  struct Pending {
    CellPolygon polygon;
    uint32_t node;
  };

  std::vector<Node> nodes_;
  std::vector<Pending> pending_;
  std::vector<uint32_t> path_;
};

template <typename Visit>
void DepthSort::FrontToBack(const Visit& visit) {
  path_.clear();
  uint32_t node = nodes_.empty() ? kNone : 0;
  while (node != kNone || !path_.empty()) {
    while (node != kNone) {
      path_.push_back(node);
      node = nodes_[node].front;
    }
    node = path_.back();
    path_.pop_back();
    if (!visit(nodes_[node].polygon)) return;
    node = nodes_[node].back;
  }
}

}  // namespace shutterline::engine::paper
