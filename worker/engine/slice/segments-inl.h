// Cuts placed triangles by lines. Included once per instruction set, by kernels.cpp.
#if defined(SHUTTERLINE_SLICE_SEGMENTS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SHUTTERLINE_SLICE_SEGMENTS_INL_H
#undef SHUTTERLINE_SLICE_SEGMENTS_INL_H
#else
#define SHUTTERLINE_SLICE_SEGMENTS_INL_H
#endif

#include <hwy/highway.h>

#include <bit>

#include "common/math/tolerance.h"
#include "worker/engine/slice/kernels.h"

HWY_BEFORE_NAMESPACE();
namespace shutterline::engine {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// The lanes whose value is above `bound`.
HWY_INLINE uint32_t LanesAbove(const HiddenBelow& values, float bound) {
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

inline size_t MakeSegmentsKernel(const GroupTriangles& triangles, const PlacedTriangles& placed, size_t first,
                                 const LineGroup& group, Stretches& stretches, int64_t& made) {
  const hn::CappedTag<double, 8> d;
  const hn::Rebind<int32_t, decltype(d)> i32;
  const hn::Rebind<float, decltype(d)> f32;
  const int n = int(hn::Lanes(d));
  const auto half = hn::Set(d, 0.5);
  const auto one = hn::Set(d, 1.0);
  SegmentLists* const lists = stretches.lists.data();
  const int shift = stretches.shift;
  alignas(64) int32_t begin[kLanes], end[kLanes];
  alignas(64) float depth[kLanes], slope[kLanes];
  uint32_t open[kMaxLinePixels];  // By stretch: the lanes on which the triangle at hand is not hidden.

  // Pointers of their own: what is appended cannot change them, which the compiler does not know.
  const double* const row_a = placed.row_a.data();
  const double* const row_b = placed.row_b.data();
  const double* const inverse_ac = placed.inverse_ac.data();
  const double* const inverse_ab = placed.inverse_ab.data();
  const double* const inverse_bc = placed.inverse_bc.data();
  const double* const position_a = placed.position_a.data();
  const double* const position_ac = placed.position_ac.data();
  const double* const position_ab = placed.position_ab.data();
  const double* const position_b = placed.position_b.data();
  const double* const position_bc = placed.position_bc.data();
  const float* const depth_a = placed.depth_a.data();
  const float* const depth_ac = placed.depth_ac.data();
  const float* const depth_ab = placed.depth_ab.data();
  const float* const depth_b = placed.depth_b.data();
  const float* const depth_bc = placed.depth_bc.data();
  const float* const nearest = placed.nearest.data();
  const int32_t* const first_lane = placed.first_lane.data();
  const int32_t* const last_lane = placed.last_lane.data();
  const int32_t* const least = placed.least.data();
  const int32_t* const most = placed.most.data();
  const uint32_t* const met = placed.met.data();
  const size_t met_count = placed.met.size();

  for (size_t m = first; m < met_count; ++m) {
    const size_t j = met[m];
    const int from = first_lane[j];
    const int to = last_lane[j];
    const uint32_t lanes = (uint32_t{2} << to) - (uint32_t{1} << from);
    const int first_stretch = least[j] >> shift;
    const int last_stretch = most[j] >> shift;
    const float triangle_nearest = nearest[j] * kFloatDepthSlack;
    uint32_t open_anywhere = 0;
    for (int k = first_stretch; k <= last_stretch; ++k) {
      open[k] = lanes & ~LanesAbove(stretches.hidden_below[size_t(k)], triangle_nearest);
      open_anywhere |= open[k];
    }
    if (open_anywhere == 0) continue;

    for (int base = from / n * n; base <= to; base += n) {
      const auto lane = hn::Iota(d, double(base));
      // The edge from the lowest to the highest corner, and the one of the two others that is met here.
      const auto u = hn::Mul(hn::Sub(lane, hn::Set(d, row_a[j])), hn::Set(d, inverse_ac[j]));
      const auto long_position = hn::Add(hn::Set(d, position_a[j]), hn::Mul(u, hn::Set(d, position_ac[j])));
      const auto long_depth =
          hn::Add(hn::Set(d, double(depth_a[j])), hn::Mul(u, hn::Set(d, double(depth_ac[j]))));
      const auto middle = hn::Set(d, row_b[j]);
      const auto upper = hn::Gt(lane, middle);
      const auto pick = [&](double above, double below)
                            HWY_ATTR { return hn::IfThenElse(upper, hn::Set(d, above), hn::Set(d, below)); };
      const auto v = hn::Mul(hn::Sub(lane, hn::IfThenElse(upper, middle, hn::Set(d, row_a[j]))),
                             pick(inverse_bc[j], inverse_ab[j]));
      const auto short_position =
          hn::Add(pick(position_b[j], position_a[j]), hn::Mul(v, pick(position_bc[j], position_ab[j])));
      const auto short_depth =
          hn::Add(pick(depth_b[j], depth_a[j]), hn::Mul(v, pick(depth_bc[j], depth_ab[j])));

      const auto long_first = hn::Le(long_position, short_position);
      const auto low = hn::Min(long_position, short_position);
      const auto high = hn::Max(long_position, short_position);
      const auto depth_low = hn::IfThenElse(long_first, long_depth, short_depth);
      const auto depth_high = hn::IfThenElse(long_first, short_depth, long_depth);

      // Round to subpixels, within the line.
      const auto line_begin = hn::PromoteTo(d, hn::LoadU(i32, group.begin.data() + base));
      const auto line_end = hn::PromoteTo(d, hn::LoadU(i32, group.end.data() + base));
      const auto b = hn::Floor(hn::Min(hn::Max(hn::Add(low, half), line_begin), line_end));
      const auto e = hn::Floor(hn::Min(hn::Max(hn::Add(high, half), line_begin), line_end));
      hn::StoreU(hn::DemoteTo(i32, b), i32, begin + base);
      hn::StoreU(hn::DemoteTo(i32, e), i32, end + base);

      // A segment shorter than a subpixel must not be steeper than from one to the next: rounding of its ends
      // would extrapolate it.
      const auto s = hn::Div(hn::Sub(depth_high, depth_low), hn::Max(hn::Sub(high, low), one));
      const auto at_begin = hn::Add(depth_low, hn::Mul(s, hn::Sub(b, low)));
      hn::StoreU(hn::DemoteTo(f32, at_begin), f32, depth + base);
      hn::StoreU(hn::DemoteTo(f32, s), f32, slope + base);
    }

    bool full = false;
    for (uint32_t left = open_anywhere; left != 0; left &= left - 1) {
      const int lane = std::countr_zero(left);
      if (begin[lane] >= end[lane]) continue;
      ++made;
      for (int k = begin[lane] >> shift; k <= (end[lane] - 1) >> shift; ++k) {
        if ((open[k] >> lane & 1) == 0) continue;
        lists[k].Append(lane, begin[lane], end[lane], depth[lane], slope[lane], triangles.index[j]);
        full |= lists[k].rows >= lists[k].compact_at;
      }
    }
    if (full) return m + 1;
  }
  return met_count;
}

}  // namespace HWY_NAMESPACE
}  // namespace shutterline::engine
HWY_AFTER_NAMESPACE();

#endif
