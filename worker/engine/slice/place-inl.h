// Places vertices and triangles at an instant. Included once per instruction set, by kernels.cpp.
#if defined(SHUTTERLINE_SLICE_PLACE_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SHUTTERLINE_SLICE_PLACE_INL_H
#undef SHUTTERLINE_SLICE_PLACE_INL_H
#else
#define SHUTTERLINE_SLICE_PLACE_INL_H
#endif

#include <hwy/highway.h>

#include <bit>
#include <limits>

#include "common/math/tolerance.h"
#include "worker/engine/slice/kernels.h"

HWY_BEFORE_NAMESPACE();
namespace shutterline::engine {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Doubles = hn::CappedTag<double, 8>;
using DoublesV = hn::Vec<Doubles>;

inline void PlaceVerticesKernel(const MovingVertices& vertices, size_t begin, size_t end, double t,
                                double far_depth, const LineAxes& axes, PlacedVertices& placed) {
  const Doubles d;
  const auto time = hn::Set(d, t);
  const auto nan = hn::Set(d, std::numeric_limits<double>::quiet_NaN());
  const auto one = hn::Set(d, 1.0);
  const auto subpixels = hn::Set(d, double(kSubpixelsPerPixel));
  const auto far = hn::Set(d, far_depth);
  const auto slope = hn::Set(d, axes.slope);
  const auto intercept = hn::Set(d, axes.intercept);
  const int major = axes.major_is_x ? 0 : 1;
  const auto& power = vertices.power;
  const size_t first_curved = vertices.first_curved();
  for (size_t i = begin; i < end; i += hn::Lanes(d)) {
    DoublesV at[kRasterCoordinates];
    if (i >= first_curved) {
      const size_t k = i - first_curved;
      const auto tau = hn::Add(hn::Mul(time, hn::LoadU(d, vertices.time_scale.data() + k)),
                               hn::LoadU(d, vertices.time_offset.data() + k));
      for (int c = 0; c < kRasterCoordinates; ++c) {
        at[c] = hn::LoadU(d, power[3][c].data() + i);
        for (int p = 2; p >= 0; --p) {
          at[c] = hn::Add(hn::LoadU(d, power[p][c].data() + i), hn::Mul(tau, at[c]));
        }
      }
    } else {
      for (int c = 0; c < kRasterCoordinates; ++c) {
        at[c] = hn::Add(hn::LoadU(d, power[0][c].data() + i),
                        hn::Mul(time, hn::LoadU(d, power[1][c].data() + i)));
      }
    }
    // Divide through by w; vertices beyond the near or the far plane get no row.
    const auto inverse = hn::Div(one, at[3]);
    const auto inside = hn::And(hn::And(hn::Ge(at[3], at[2]), hn::Gt(at[3], hn::Zero(d))),
                                hn::Ge(at[2], hn::Mul(far, at[3])));
    const auto position = hn::Mul(at[major], inverse);
    const auto minor = hn::Mul(at[1 - major], inverse);
    const auto row = hn::Sub(hn::Sub(minor, hn::Mul(slope, position)), intercept);
    hn::StoreU(hn::IfThenElse(inside, row, nan), d, placed.row.data() + i);
    hn::StoreU(hn::Mul(position, subpixels), d, placed.position.data() + i);
    hn::StoreU(hn::Mul(at[2], inverse), d, placed.depth.data() + i);
    hn::StoreU(inverse, d, placed.inverse_w.data() + i);
  }
}

/// Appends the numbers of the lanes that are set, counted from `first`.
HWY_INLINE void AppendSet(Doubles d, hn::Mask<Doubles> mask, size_t first, uint8_t* numbers, size_t& count) {
  uint8_t bits[8] = {0};
  hn::StoreMaskBits(d, mask, bits);
  for (uint32_t left = bits[0]; left != 0; left &= left - 1) {
    numbers[count++] = uint8_t(first + size_t(std::countr_zero(left)));
  }
}

inline void PlaceTrianglesKernel(const GroupTriangles& triangles, size_t begin, size_t end,
                                 const PlacedVertices& vertices, double t, const LineClass& lines,
                                 PlacedTriangles& out) {
  const Doubles d;
  const hn::Rebind<int32_t, Doubles> i32;
  const hn::Rebind<int64_t, Doubles> i64;
  const hn::Rebind<float, Doubles> f32;
  const size_t n = hn::Lanes(d);
  const auto zero = hn::Zero(d);
  const auto one = hn::Set(d, 1.0);
  const auto largest = hn::Set(d, std::numeric_limits<double>::max());
  const auto time = hn::Set(d, t);
  const auto last_row = hn::Set(d, double(lines.rows() - 1));
  const auto line_end = hn::Set(d, double(lines.length) * double(kSubpixelsPerPixel));
  // Raster y points down, which makes triangles that turn counter-clockwise turn the other way, and
  // exchanging the axes turns them again.
  const auto facing = hn::Set(d, lines.axes.major_is_x ? 1.0 : -1.0);

  out.met_count = 0;
  out.clipped_count = 0;
  for (size_t i = begin; i < end; i += n) {
    const auto in_time = hn::And(hn::Le(hn::LoadU(d, triangles.t_in.data() + i), time),
                                 hn::Ge(hn::LoadU(d, triangles.t_out.data() + i), time));
    if (hn::AllFalse(d, in_time)) continue;

    DoublesV row[3], position[3], depth[3];
    for (int c = 0; c < 3; ++c) {
      const auto at = hn::PromoteTo(i64, hn::LoadU(i32, triangles.vertex[c].data() + i));
      row[c] = hn::GatherIndex(d, vertices.row.data(), at);
      position[c] = hn::GatherIndex(d, vertices.position.data(), at);
      depth[c] = hn::GatherIndex(d, vertices.depth.data(), at);
    }
    const auto nan = hn::IsNaN(hn::Add(hn::Add(row[0], row[1]), row[2]));
    const auto usable = hn::AndNot(nan, in_time);
    const auto to_clip = hn::And(nan, in_time);

    // Which way it faces, before the corners are sorted.
    const auto area = hn::Sub(hn::Mul(hn::Sub(row[1], row[0]), hn::Sub(position[2], position[0])),
                              hn::Mul(hn::Sub(row[2], row[0]), hn::Sub(position[1], position[0])));
    const auto sided = hn::Mul(facing, hn::LoadU(d, triangles.one_sided.data() + i));
    const auto away = hn::Lt(hn::Mul(area, sided), zero);

    const auto order = [&](int a, int b) HWY_ATTR {
      const auto swap = hn::Lt(row[b], row[a]);
      for (auto* value : {row, position, depth}) {
        const auto low = hn::IfThenElse(swap, value[b], value[a]);
        value[b] = hn::IfThenElse(swap, value[a], value[b]);
        value[a] = low;
      }
    };
    order(0, 1);
    order(1, 2);
    order(0, 1);

    // Rows strictly above the lowest corner up to the highest, see the convention for f = 0.
    const auto first = hn::Max(zero, hn::Add(hn::Floor(row[0]), one));
    const auto last = hn::Min(last_row, hn::Floor(row[2]));
    const auto least = hn::Min(position[0], hn::Min(position[1], position[2]));
    const auto most = hn::Max(position[0], hn::Max(position[1], position[2]));
    const auto meets =
        hn::And(hn::AndNot(away, hn::Le(first, last)), hn::And(hn::Gt(most, zero), hn::Lt(least, line_end)));
    const auto all = hn::And(meets, usable);

    const size_t k = i - begin;
    if (!hn::AllFalse(d, to_clip)) AppendSet(d, to_clip, k, out.clipped.data(), out.clipped_count);
    if (hn::AllFalse(d, all)) continue;
    AppendSet(d, all, k, out.met.data(), out.met_count);

    const auto store = [&](DoublesV v, PlacedTriangles::Array<double>& to)
                           HWY_ATTR { hn::StoreU(v, d, to.data() + k); };
    const auto store_float = [&](DoublesV v, PlacedTriangles::Array<float>& to)
                                 HWY_ATTR { hn::StoreU(hn::DemoteTo(f32, v), f32, to.data() + k); };
    const auto store_int = [&](DoublesV v, PlacedTriangles::Array<int32_t>& to)
                               HWY_ATTR { hn::StoreU(hn::DemoteTo(i32, v), i32, to.data() + k); };
    // Of a denormal height it would overflow, and its product with that height again would not be a share.
    const auto reciprocal = [&](DoublesV v) HWY_ATTR { return hn::Min(hn::Div(one, v), largest); };
    store(row[0], out.row_a);
    store(row[1], out.row_b);
    store(reciprocal(hn::Sub(row[2], row[0])), out.inverse_ac);
    store(reciprocal(hn::Sub(row[1], row[0])), out.inverse_ab);
    store(reciprocal(hn::Sub(row[2], row[1])), out.inverse_bc);
    store(position[0], out.position_a);
    store(hn::Sub(position[2], position[0]), out.position_ac);
    store(hn::Sub(position[1], position[0]), out.position_ab);
    store(position[1], out.position_b);
    store(hn::Sub(position[2], position[1]), out.position_bc);
    store_float(depth[0], out.depth_a);
    store_float(hn::Sub(depth[2], depth[0]), out.depth_ac);
    store_float(hn::Sub(depth[1], depth[0]), out.depth_ab);
    store_float(depth[1], out.depth_b);
    store_float(hn::Sub(depth[2], depth[1]), out.depth_bc);
    store_float(hn::Max(depth[0], hn::Max(depth[1], depth[2])), out.nearest);
    store_int(first, out.first_row);
    store_int(last, out.last_row);
    store_int(hn::Max(hn::Sub(least, one), zero), out.least);
    store_int(hn::Min(hn::Add(most, one), hn::Sub(line_end, one)), out.most);
  }
}

inline const char* TargetName() {
  return hwy::TargetName(HWY_TARGET);
}

}  // namespace HWY_NAMESPACE
}  // namespace shutterline::engine
HWY_AFTER_NAMESPACE();

#endif
