#pragma once

#include <cstdint>

#include "worker/engine/paper/depth_patch.h"

namespace shutterline::engine::paper {

struct DepthRange {
  double farthest = 0, nearest = 0;
};

/// A piece of a depth patch in (l, t, d) as the visibility engine bins it: a slab, convex in (l, t).
///
/// Stands where [gribel2011] has two patch triangles. Depth is interpolated along the segment at each
/// instant, so it is bilinear over the slab and needs no diagonal; a plane is fitted only to what a cell
/// cuts out of it. See docs/decisions/2026-11-22-patch-planes-per-cell.md.
struct PatchPiece {
  Slab slab;
  uint32_t index = 0;                ///< Of the triangle in TileTriangles.
  uint32_t id = 0;                   ///< The triangle's: the lower wins where depths are equal.
  double farthest = 0, nearest = 0;  ///< Depths over the piece.

  PatchPiece() = default;
  PatchPiece(const Slab& source, uint32_t triangle_index, uint32_t triangle_id);

  /// Depth at a point of the piece; outside of it that of a point on its sides.
  double DepthAt(double l, double t) const;

  /// Bounds of DepthAt over the part of the piece within [l0, l1] × [t0, t1].
  DepthRange RangeOver(double l0, double l1, double t0, double t1) const;

 private:
  struct Segment {
    double left, right, depth_left, depth_right;
    double Fraction(double l) const;
  };
  Segment At(double t) const;
};

}  // namespace shutterline::engine::paper
