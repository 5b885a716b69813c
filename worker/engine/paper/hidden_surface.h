#pragma once

#include <cstdint>
#include <vector>

#include "worker/engine/paper/polygon.h"

namespace shutterline::engine::paper {

/// A visible piece of a triangle within a cell: convex.
struct VisibleFragment {
  uint32_t index = 0;   ///< Of the triangle in TileTriangles.
  double area = 0;      ///< Of the cell's 1.
  double u = 0, v = 0;  ///< Its centre in the cell.
};

/// Removes what is hidden from polygons that come front to back: the pixel integrator of [catmull1978] in
/// (l, t) [gribel2011, section 5.3 and figure 5].
///
/// A tree of edges: each polygon that is seen cuts the region in which it lies, edge by edge, into the part
/// outside of that edge, which is a subtree of its own, and the rest. What is inside of all edges is
/// hidden by that polygon. A later polygon is cut by the same edges on its way down; where it comes to a
/// region that nothing covers yet, it is seen.
class HiddenSurface {
 public:
  /// Begins a region in which nothing is covered.
  void Clear() {
    edges_.clear();
    root_ = {};
  }

  /// Adds the visible parts of `polygon` to `fragments`; returns their area.
  double Insert(const Polygon& polygon, uint32_t index, PolygonArena& arena,
                std::vector<VisibleFragment>& fragments);

 private:
  /// The edges of the polygon that covers a region; count 0 where nothing does.
  struct Region {
    uint32_t first_edge = 0, count = 0;
  };
  struct Edge {
    HalfPlane inside;
    Region outside;
  };

  /// Region kRoot is the whole; others are named by their edge.
  static constexpr uint32_t kRoot = ~uint32_t{0};
  Region& RegionOf(uint32_t name) { return name == kRoot ? root_ : edges_[name].outside; }

  double Descend(uint32_t region, Polygon polygon, uint32_t index, PolygonArena& arena,
                 std::vector<VisibleFragment>& fragments);
  void Cover(uint32_t region, const Polygon& polygon, const PolygonArena& arena);

  Region root_;
  std::vector<Edge> edges_;
};

}  // namespace shutterline::engine::paper
