#include "worker/engine/paper/patch_piece.h"

#include <algorithm>

namespace shutterline::engine::paper {

PatchPiece::PatchPiece(const Slab& source, uint32_t triangle_index, uint32_t triangle_id)
    : slab(source), index(triangle_index), id(triangle_id) {
  // Where the sides meet in a tip, depth there is the mean of both.
  if (!(slab.left0 < slab.right0)) {
    slab.depth_left0 = slab.depth_right0 = 0.5 * (slab.depth_left0 + slab.depth_right0);
  }
  if (!(slab.left1 < slab.right1)) {
    slab.depth_left1 = slab.depth_right1 = 0.5 * (slab.depth_left1 + slab.depth_right1);
  }
  const auto [low, high] =
      std::minmax({slab.depth_left0, slab.depth_left1, slab.depth_right0, slab.depth_right1});
  farthest = low;
  nearest = high;
}

double PatchPiece::Segment::Fraction(double l) const {
  const double width = right - left;
  return width > 0 ? std::clamp((l - left) / width, 0.0, 1.0) : 0.5;
}

PatchPiece::Segment PatchPiece::At(double t) const {
  const double s = std::clamp((t - slab.t0) / (slab.t1 - slab.t0), 0.0, 1.0);
  const auto mix = [s](double a, double b) { return s == 1 ? b : a + s * (b - a); };
  return {mix(slab.left0, slab.left1), mix(slab.right0, slab.right1), mix(slab.depth_left0, slab.depth_left1),
          mix(slab.depth_right0, slab.depth_right1)};
}

double PatchPiece::DepthAt(double l, double t) const {
  const Segment at = At(t);
  return at.depth_left + at.Fraction(l) * (at.depth_right - at.depth_left);
}

DepthRange PatchPiece::RangeOver(double l0, double l1, double t0, double t1) const {
  // The fraction along the segment is monotone in l, and at a fixed l, as a ratio of linear functions, in t:
  // it is bounded by its values at the corners. Depth is bilinear in that fraction and t.
  const Segment a = At(t0);
  const Segment b = At(t1);
  const auto [low, high] = std::minmax({a.Fraction(l0), a.Fraction(l1), b.Fraction(l0), b.Fraction(l1)});
  DepthRange range{nearest, farthest};
  for (const Segment* at : {&a, &b}) {
    for (const double s : {low, high}) {
      const double d = at->depth_left + s * (at->depth_right - at->depth_left);
      range.farthest = std::min(range.farthest, d);
      range.nearest = std::max(range.nearest, d);
    }
  }
  return range;
}

}  // namespace shutterline::engine::paper
