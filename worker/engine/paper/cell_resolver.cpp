#include "worker/engine/paper/cell_resolver.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "common/math/tolerance.h"

namespace shutterline::engine::paper {

void CellResolver::Resolve(const CellBounds& cell, std::span<const uint32_t> pieces,
                           std::span<const PatchPiece> all) {
  arena_.Clear();
  polygons_.clear();
  fragments_.clear();
  bool one_triangle = true;
  for (const uint32_t piece : pieces) {
    AddPiece(cell, all[piece]);
    one_triangle &= all[piece].index == all[pieces.front()].index;
  }
  if (one_triangle) {
    // Pieces of one triangle hide nothing of one another: at an instant it is one segment.
    for (const CellPolygon& polygon : polygons_) {
      const PolygonMoments m = arena_.MomentsOf(polygon.polygon);
      if (m.area > 0) fragments_.push_back({polygon.index, m.area, m.u / m.area, m.v / m.area});
    }
    return;
  }
  ResolveRegion(0, {}, 0);
}

void CellResolver::AddPiece(const CellBounds& cell, const PatchPiece& piece) {
  const double height = cell.t1 - cell.t0;
  const Slab& slab = piece.slab;
  const uint32_t begin = arena_.Begin();
  const auto corner = [&](double l, double t) {
    // What ends where the cell ends is put there exactly.
    arena_.Append({l - cell.l0, t == cell.t1 ? 1 : (t - cell.t0) / height});
  };
  corner(slab.left0, slab.t0);
  if (slab.left0 < slab.right0) corner(slab.right0, slab.t0);
  corner(slab.right1, slab.t1);
  if (slab.left1 < slab.right1) corner(slab.left1, slab.t1);
  Polygon polygon = arena_.End(begin);
  constexpr HalfPlane kBorders[] = {{1, 0, 0}, {-1, 0, 1}, {0, 1, 0}, {0, -1, 1}};
  for (const HalfPlane& border : kBorders) {
    const PolygonSplit split = arena_.Split(polygon, border, 0);
    if (split.positive.count == 0) return;
    polygon = split.positive;
  }
  AddFitted(cell, piece, polygon, options_.plane_halvings);
}

/// Fits a plane through three corners of a polygon, those that span most, and halves the polygon as long
/// as that is too far from the depth of another corner.
void CellResolver::AddFitted(const CellBounds& cell, const PatchPiece& piece, const Polygon& polygon,
                             int halvings) {
  const uint32_t count = polygon.count;
  depths_.resize(count);
  for (uint32_t i = 0; i < count; ++i) {
    const CellPoint& p = arena_.At(polygon, i);
    depths_[i] = piece.DepthAt(cell.l0 + p.u, cell.t0 + p.v * (cell.t1 - cell.t0));
  }
  double most = 0;
  uint32_t at[3] = {0, 0, 0};
  for (uint32_t i = 0; i + 2 < count; ++i) {
    for (uint32_t j = i + 1; j + 1 < count; ++j) {
      for (uint32_t k = j + 1; k < count; ++k) {
        const CellPoint &a = arena_.At(polygon, i), &b = arena_.At(polygon, j), &c = arena_.At(polygon, k);
        const double area = (b.u - a.u) * (c.v - a.v) - (b.v - a.v) * (c.u - a.u);
        if (area > most) {
          most = area;
          at[0] = i, at[1] = j, at[2] = k;
        }
      }
    }
  }
  if (!(most > 0)) return;
  const CellPoint &a = arena_.At(polygon, at[0]), &b = arena_.At(polygon, at[1]),
                  &c = arena_.At(polygon, at[2]);
  const double bd = depths_[at[1]] - depths_[at[0]];
  const double cd = depths_[at[2]] - depths_[at[0]];
  CellPolygon fitted;
  fitted.polygon = polygon;
  fitted.index = piece.index;
  fitted.id = piece.id;
  fitted.plane.du = (bd * (c.v - a.v) - cd * (b.v - a.v)) / most;
  fitted.plane.dv = (cd * (b.u - a.u) - bd * (c.u - a.u)) / most;
  fitted.plane.d = depths_[at[0]] - fitted.plane.du * a.u - fitted.plane.dv * a.v;

  if (count > 3 && halvings > 0) {
    double off = 0;
    for (uint32_t i = 0; i < count; ++i) {
      off = std::max(off, std::abs(fitted.plane.At(arena_.At(polygon, i)) - depths_[i]));
    }
    if (off > options_.depth_tolerance * piece.nearest) {
      CellPoint low{1, 1};
      CellPoint high{0, 0};
      for (uint32_t i = 0; i < count; ++i) {
        const CellPoint& p = arena_.At(polygon, i);
        low = {std::min(low.u, p.u), std::min(low.v, p.v)};
        high = {std::max(high.u, p.u), std::max(high.v, p.v)};
      }
      const bool along_line = high.u - low.u > high.v - low.v;
      const HalfPlane middle =
          along_line ? HalfPlane{1, 0, -0.5 * (low.u + high.u)} : HalfPlane{0, 1, -0.5 * (low.v + high.v)};
      const PolygonSplit split = arena_.Split(polygon, middle, 0);
      if (split.positive.count != 0) AddFitted(cell, piece, split.positive, halvings - 1);
      if (split.negative.count != 0) AddFitted(cell, piece, split.negative, halvings - 1);
      return;
    }
  }
  BoundDepth(fitted);
  polygons_.push_back(fitted);
}

void CellResolver::BoundDepth(CellPolygon& p) const {
  p.nearest = -std::numeric_limits<double>::infinity();
  p.farthest = std::numeric_limits<double>::infinity();
  for (uint32_t i = 0; i < p.polygon.count; ++i) {
    const CellPoint& at = arena_.At(p.polygon, i);
    const double d = p.plane.At(at);
    p.nearest = std::max(p.nearest, d);
    p.farthest = std::min(p.farthest, d);
  }
}

void CellResolver::ResolveRegion(size_t first, const Rectangle& region, int level) {
  CullHidden(first, region);
  if (polygons_.size() - first > kMostInTree && ResolveHalves(first, region, level)) return;
  ResolveByTree(first, region);
}

/// Drops what lies behind a polygon that covers the region [gribel2011, section 5.1].
void CellResolver::CullHidden(size_t first, const Rectangle& region) {
  double hidden_below = -std::numeric_limits<double>::infinity();
  for (size_t i = first; i < polygons_.size(); ++i) {
    const CellPolygon& p = polygons_[i];
    if (p.farthest > hidden_below && arena_.MomentsOf(p.polygon).area >= region.Area() * (1 - kOnLine)) {
      hidden_below = p.farthest;
    }
  }
  if (!std::isfinite(hidden_below)) return;
  const double slack = kEqualDepth * std::abs(hidden_below);
  const auto hidden = [&](const CellPolygon& p) { return p.nearest < hidden_below - slack; };
  polygons_.erase(std::remove_if(polygons_.begin() + ptrdiff_t(first), polygons_.end(), hidden),
                  polygons_.end());
}

/// False, and nothing done, where cutting the region would leave about as many polygons in both halves.
bool CellResolver::ResolveHalves(size_t first, const Rectangle& region, int level) {
  constexpr int kMaxLevel = 40;
  if (level >= kMaxLevel) return false;
  const bool along_line = region.u1 - region.u0 >= region.v1 - region.v0;
  const double middle = along_line ? 0.5 * (region.u0 + region.u1) : 0.5 * (region.v0 + region.v1);
  const HalfPlane below = along_line ? HalfPlane{-1, 0, middle} : HalfPlane{0, -1, middle};
  const HalfPlane above = along_line ? HalfPlane{1, 0, -middle} : HalfPlane{0, 1, -middle};

  // Count first: each polygon in both halves is one that cutting does not help.
  const size_t count = polygons_.size() - first;
  size_t in_both = 0;
  for (size_t i = first; i < polygons_.size(); ++i) {
    double low = 0;
    double high = 0;
    for (uint32_t k = 0; k < polygons_[i].polygon.count; ++k) {
      const double at = above.At(arena_.At(polygons_[i].polygon, k));
      low = std::min(low, at);
      high = std::max(high, at);
    }
    in_both += low < 0 && high > 0;
  }
  if (2 * in_both > count) return false;

  for (const bool upper : {false, true}) {
    Rectangle half = region;
    if (along_line) {
      (upper ? half.u0 : half.u1) = middle;
    } else {
      (upper ? half.v0 : half.v1) = middle;
    }
    const size_t mark = arena_.Mark();
    const size_t begin = polygons_.size();
    for (size_t i = first; i < first + count; ++i) {
      const PolygonSplit split = arena_.Split(polygons_[i].polygon, upper ? above : below, 0);
      if (split.positive.count == 0) continue;
      CellPolygon part = polygons_[i];
      part.polygon = split.positive;
      BoundDepth(part);
      polygons_.push_back(part);
    }
    ResolveRegion(begin, half, level + 1);
    polygons_.resize(begin);
    arena_.Release(mark);
  }
  return true;
}

void CellResolver::ResolveByTree(size_t first, const Rectangle& region) {
  // Nearest first: planes in front cut little, and what is hidden by few polygons is found soon. The
  // order is one of what the polygons are, not of how they came.
  std::sort(polygons_.begin() + ptrdiff_t(first), polygons_.end(),
            [](const CellPolygon& a, const CellPolygon& b) {
              return std::tie(b.nearest, b.farthest, a.id) < std::tie(a.nearest, a.farthest, b.id);
            });
  hidden_surface_.Clear();
  double free_area = region.Area();
  const auto see = [&](const CellPolygon& p) {
    free_area -= hidden_surface_.Insert(p.polygon, p.index, arena_, fragments_);
    return free_area > kOnLine;  // Full: what follows is hidden.
  };
  // Polygons whose depths are apart need no tree: cut the list where no range of depths reaches across. What
  // is behind a full cell is then never sorted.
  const size_t count = polygons_.size();
  for (size_t begin = first; begin < count && free_area > kOnLine;) {
    double farthest = polygons_[begin].farthest;
    size_t end = begin + 1;
    while (end < count && polygons_[end].nearest >= farthest) {
      farthest = std::min(farthest, polygons_[end++].farthest);
    }
    const double nearest = polygons_[begin].nearest;
    if (end == begin + 1) {
      see(polygons_[begin]);
    } else if (nearest - farthest <= kEqualDepth * std::abs(nearest)) {
      // All equally far: by number.
      std::sort(polygons_.begin() + ptrdiff_t(begin), polygons_.begin() + ptrdiff_t(end),
                [](const CellPolygon& a, const CellPolygon& b) { return a.id < b.id; });
      for (size_t i = begin; i < end && see(polygons_[i]);) ++i;
    } else {
      const size_t mark = arena_.Mark();
      depth_sort_.Clear();
      for (size_t i = begin; i < end; ++i) depth_sort_.Insert(polygons_[i], arena_);
      depth_sort_.FrontToBack(see);
      arena_.Release(mark);
    }
    begin = end;
  }
}

}  // namespace shutterline::engine::paper
