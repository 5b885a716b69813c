// Cuts placed triangles by lines. Included once per instruction set, by kernels.cpp.
#if defined(SHUTTERLINE_SLICE_SEGMENTS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SHUTTERLINE_SLICE_SEGMENTS_INL_H
#undef SHUTTERLINE_SLICE_SEGMENTS_INL_H
#else
#define SHUTTERLINE_SLICE_SEGMENTS_INL_H
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <bit>

#include "common/math/tolerance.h"
#include "worker/engine/slice/kernels.h"

HWY_BEFORE_NAMESPACE();
namespace shutterline::engine {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// The lanes whose value is above `bound`.
HWY_INLINE uint32_t LanesAbove(const std::array<float, kLanes>& values, float bound) {
  const hn::CappedTag<float, kLanes> d;
  const auto limit = hn::Set(d, bound);
  uint32_t lanes = 0;
  for (size_t base = 0; base < kLanes; base += hn::Lanes(d)) {
    uint8_t bits[8] = {0};
    hn::StoreMaskBits(d, hn::Gt(hn::LoadU(d, values.data() + base), limit), bits);
    lanes |= (uint32_t{bits[0]} | uint32_t{bits[1]} << 8) << base;
  }
  return lanes;
}

/// Segments of one triangle, by lane; a vector may be written past the last lane.
struct LaneSegments {
  alignas(64) int32_t begin[2 * kLanes], end[2 * kLanes];
  alignas(64) float depth[2 * kLanes], slope[2 * kLanes];
};

/// Cuts triangle j by the group's lanes [from, to], Lanes(d) at a time.
template <class D>
HWY_INLINE void CutTriangle(D d, const PlacedTriangles& placed, size_t j, int from, int to,
                            const LineGroup& group, LaneSegments& out) {
  const hn::Rebind<int32_t, D> i32;
  const hn::Rebind<float, D> f32;
  const auto half = hn::Set(d, 0.5);
  const auto one = hn::Set(d, 1.0);
  const auto all = [&](double value) HWY_ATTR { return hn::Set(d, value); };
  const auto row_a = all(placed.row_a[j]);
  const auto row_b = all(placed.row_b[j]);
  const auto position_a = all(placed.position_a[j]);
  const auto depth_a = all(double(placed.depth_a[j]));
  const auto least = all(double(placed.least[j]));
  const auto end = all(double(placed.most[j]) + 1);

  for (int lanes = from; lanes <= to; lanes += int(hn::Lanes(d))) {
    const auto lane = hn::Iota(d, double(group.first_row + lanes));  // As a row.
    // The edge from the lowest to the highest corner, and the one of the two others that is met here.
    const auto u = hn::Mul(hn::Sub(lane, row_a), all(placed.inverse_ac[j]));
    const auto long_position = hn::Add(position_a, hn::Mul(u, all(placed.position_ac[j])));
    const auto long_depth = hn::Add(depth_a, hn::Mul(u, all(double(placed.depth_ac[j]))));
    const auto upper = hn::Gt(lane, row_b);
    const auto pick = [&](double above, double below)
                          HWY_ATTR { return hn::IfThenElse(upper, all(above), all(below)); };
    const auto v = hn::Mul(hn::Sub(lane, hn::IfThenElse(upper, row_b, row_a)),
                           pick(placed.inverse_bc[j], placed.inverse_ab[j]));
    const auto short_position = hn::Add(hn::IfThenElse(upper, all(placed.position_b[j]), position_a),
                                        hn::Mul(v, pick(placed.position_bc[j], placed.position_ab[j])));
    const auto short_depth = hn::Add(hn::IfThenElse(upper, all(double(placed.depth_b[j])), depth_a),
                                     hn::Mul(v, pick(placed.depth_bc[j], placed.depth_ab[j])));

    const auto long_first = hn::Le(long_position, short_position);
    const auto low = hn::Min(long_position, short_position);
    const auto high = hn::Max(long_position, short_position);
    const auto depth_low = hn::IfThenElse(long_first, long_depth, short_depth);
    const auto depth_high = hn::IfThenElse(long_first, short_depth, long_depth);

    // Round to subpixels, within the line and, where rounding of far corners left them, the triangle's
    // bounds: truncation rounds to nearest, as positions are not negative.
    const auto line_begin = hn::Max(hn::PromoteTo(d, hn::LoadU(i32, group.begin.data() + lanes)), least);
    const auto line_end = hn::Min(hn::PromoteTo(d, hn::LoadU(i32, group.end.data() + lanes)), end);
    const auto b = hn::DemoteTo(i32, hn::Min(hn::Max(hn::Add(low, half), line_begin), line_end));
    const auto e = hn::DemoteTo(i32, hn::Min(hn::Max(hn::Add(high, half), line_begin), line_end));
    hn::StoreU(b, i32, out.begin + lanes);
    hn::StoreU(e, i32, out.end + lanes);

    // A segment shorter than a subpixel must not be steeper than from one to the next: rounding of its ends
    // would extrapolate it.
    const auto s = hn::Div(hn::Sub(depth_high, depth_low), hn::Max(hn::Sub(high, low), one));
    const auto at_begin = hn::Add(depth_low, hn::Mul(s, hn::Sub(hn::PromoteTo(d, b), low)));
    hn::StoreU(hn::DemoteTo(f32, at_begin), f32, out.depth + lanes);
    hn::StoreU(hn::DemoteTo(f32, s), f32, out.slope + lanes);
  }
}

inline size_t MakeSegmentsKernel(const PlacedTriangles& placed, size_t first, const LineGroup& group,
                                 Stretches& stretches, int64_t& made) {
  SegmentLists* const lists = stretches.lists.data();
  const int shift = stretches.shift;
  LaneSegments cut;
  uint32_t open[kMaxLinePixels];  // By stretch: the lanes on which the triangle at hand is not hidden.

  for (size_t m = first; m < placed.met_count; ++m) {
    const size_t j = placed.met[m];
    const int from = std::max(placed.first_row[j] - group.first_row, 0);
    const int to = std::min(placed.last_row[j] - group.first_row, group.lanes - 1);
    if (from > to) continue;
    const uint32_t lanes = (uint32_t{2} << to) - (uint32_t{1} << from);
    const int first_stretch = placed.least[j] >> shift;
    const int last_stretch = placed.most[j] >> shift;
    const float triangle_nearest = placed.nearest[j] * kFloatDepthSlack;
    uint32_t open_anywhere = 0;
    for (int k = first_stretch; k <= last_stretch; ++k) {
      const HiddenBelow& hidden = stretches.hidden_below[size_t(k)];
      open[k] = hidden.all > triangle_nearest ? 0 : lanes & ~LanesAbove(hidden.lanes, triangle_nearest);
      open_anywhere |= open[k];
    }
    if (open_anywhere == 0) continue;

    // Most triangles are small: a short vector is quicker then.
    if (to - from < 4) {
      CutTriangle(hn::CappedTag<double, 4>(), placed, j, from, to, group, cut);
    } else {
      CutTriangle(hn::CappedTag<double, 8>(), placed, j, from, to, group, cut);
    }

    bool full = false;
    for (uint32_t left = open_anywhere; left != 0; left &= left - 1) {
      const int lane = std::countr_zero(left);
      if (cut.begin[lane] >= cut.end[lane]) continue;
      ++made;
      for (int k = cut.begin[lane] >> shift; k <= (cut.end[lane] - 1) >> shift; ++k) {
        if ((open[k] >> lane & 1) == 0) continue;
        lists[k].Append(lane, cut.begin[lane], cut.end[lane], cut.depth[lane], cut.slope[lane],
                        placed.index[j]);
        full |= lists[k].rows >= lists[k].compact_at;
      }
    }
    if (full) return m + 1;
  }
  return placed.met_count;
}

}  // namespace HWY_NAMESPACE
}  // namespace shutterline::engine
HWY_AFTER_NAMESPACE();

#endif
