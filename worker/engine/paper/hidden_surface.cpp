#include "worker/engine/paper/hidden_surface.h"

#include <cmath>

#include "common/math/tolerance.h"

namespace shutterline::engine::paper {
namespace {

/// In units of a cell. Corners are exact to some 2^-50, so a longer edge is straight to 2^-30 over the cell.
constexpr double kShortEdge = 0x1p-20;

/// Less than this of a cell is rounding: its edges would have no direction.
constexpr double kLeastArea = 0x1p-46;

}  // namespace

double HiddenSurface::Insert(const Polygon& polygon, uint32_t index, PolygonArena& arena,
                             std::vector<VisibleFragment>& fragments) {
  const size_t mark = arena.Mark();
  const double area = Descend(kRoot, polygon, index, arena, fragments);
  arena.Release(mark);
  return area;
}

double HiddenSurface::Descend(uint32_t region, Polygon polygon, uint32_t index, PolygonArena& arena,
                              std::vector<VisibleFragment>& fragments) {
  const Region covered = RegionOf(region);
  if (covered.count == 0) {
    const PolygonMoments moments = arena.MomentsOf(polygon);
    if (!(moments.area > kLeastArea)) return 0;
    Cover(region, polygon, arena);
    fragments.push_back({index, moments.area, moments.u / moments.area, moments.v / moments.area});
    return moments.area;
  }
  double seen = 0;
  for (uint32_t e = covered.first_edge; e < covered.first_edge + covered.count; ++e) {
    const PolygonSplit split = arena.Split(polygon, edges_[e].inside, kOnLine);
    if (split.negative.count != 0) {
      const size_t mark = arena.Mark();
      seen += Descend(e, split.negative, index, arena, fragments);
      arena.Release(mark);
    }
    if (split.positive.count == 0) return seen;
    polygon = split.positive;
  }
  return seen;
}

void HiddenSurface::Cover(uint32_t region, const Polygon& polygon, const PolygonArena& arena) {
  struct Direction {
    double u, v, length;
  };
  const auto direction = [&](uint32_t i) -> Direction {
    const CellPoint& p = arena.At(polygon, i % polygon.count);
    const CellPoint& q = arena.At(polygon, (i + 1) % polygon.count);
    const double length = std::hypot(q.u - p.u, q.v - p.v);
    return {(q.u - p.u) / length, (q.v - p.v) / length, length};
  };
  // The direction of a very short edge is rounding. Where it goes on in a neighbour's direction it is left
  // out, or its line might run into the polygon; at a true corner an error in its direction does no harm.
  const auto goes_on = [](const Direction& d, const Direction& neighbour) {
    return std::abs(d.u * neighbour.v - d.v * neighbour.u) < 0.05 &&
           d.u * neighbour.u + d.v * neighbour.v > 0;
  };

  Region covered{.first_edge = uint32_t(edges_.size()), .count = 0};
  Direction kept = direction(polygon.count - 1);
  for (uint32_t i = 0; i < polygon.count; ++i) {
    const Direction d = direction(i);
    if (d.length <= kOnLine) continue;
    if (d.length < kShortEdge) {
      // Not at the tip of a needle: its long edges would run on until they meet, far away.
      const Direction next = direction(i + 1);
      const bool blunt = kept.u * next.u + kept.v * next.v > 0;
      if (blunt && (goes_on(d, kept) || goes_on(d, next))) continue;
    }
    const CellPoint& p = arena.At(polygon, i);
    edges_.push_back({.inside = {-d.v, d.u, d.v * p.u - d.u * p.v}, .outside = {}});
    ++covered.count;
    kept = d;
  }
  RegionOf(region) = covered;
}

}  // namespace shutterline::engine::paper
