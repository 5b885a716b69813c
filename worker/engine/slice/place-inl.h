// Places vertices and triangles at an instant. Included once per instruction set, by kernels.cpp.
#if defined(SHUTTERLINE_SLICE_PLACE_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SHUTTERLINE_SLICE_PLACE_INL_H
#undef SHUTTERLINE_SLICE_PLACE_INL_H
#else
#define SHUTTERLINE_SLICE_PLACE_INL_H
#endif

#include <hwy/highway.h>

#include <limits>

#include "common/math/tolerance.h"
#include "worker/engine/slice/kernels.h"

HWY_BEFORE_NAMESPACE();
namespace shutterline::engine {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Doubles = hn::CappedTag<double, 8>;
using DoublesV = hn::Vec<Doubles>;

/// Divides through by w.
HWY_INLINE void Project(Doubles d, size_t i, DoublesV f, DoublesV g, DoublesV z, DoublesV w,
                        PlacedVertices& placed) {
  const auto inverse = hn::Div(hn::Set(d, 1.0), w);
  hn::StoreU(hn::Mul(f, inverse), d, placed.row.data() + i);
  hn::StoreU(hn::Mul(hn::Mul(g, inverse), hn::Set(d, double(kSubpixelsPerPixel))), d,
             placed.position.data() + i);
  hn::StoreU(hn::Mul(z, inverse), d, placed.depth.data() + i);
}

inline void ProjectVerticesKernel(size_t begin, size_t end, PlacedVertices& placed) {
  const Doubles d;
  const auto& at = placed.homogeneous;
  for (size_t i = begin; i < end; i += hn::Lanes(d)) {
    Project(d, i, hn::LoadU(d, at[0].data() + i), hn::LoadU(d, at[1].data() + i),
            hn::LoadU(d, at[2].data() + i), hn::LoadU(d, at[3].data() + i), placed);
  }
}

inline void PlaceVerticesKernel(const MovingVertices& vertices, double t, double far_depth,
                                PlacedVertices& placed) {
  const Doubles d;
  const size_t lanes = hn::Lanes(d);
  const auto time = hn::Set(d, t);
  const auto nan = hn::Set(d, std::numeric_limits<double>::quiet_NaN());
  const auto& power = vertices.power;
  const auto place = [&](size_t i, const auto& evaluate) HWY_ATTR {
    DoublesV at[kLineCoordinates];
    for (int c = 0; c < kLineCoordinates; ++c) {
      at[c] = evaluate(c);
      hn::StoreU(at[c], d, placed.homogeneous[c].data() + i);
    }
    Project(d, i, at[0], at[1], at[2], at[3], placed);
    // Vertices beyond the near or the far plane have no row.
    const auto inside = hn::And(hn::And(hn::Ge(at[3], at[2]), hn::Gt(at[3], hn::Zero(d))),
                                hn::Ge(at[2], hn::Mul(hn::Set(d, far_depth), at[3])));
    hn::StoreU(hn::IfThenElse(inside, hn::LoadU(d, placed.row.data() + i), nan), d, placed.row.data() + i);
  };
  for (size_t i = 0; i < vertices.linear; i += lanes) {
    place(i, [&](int c) HWY_ATTR {
      return hn::Add(hn::LoadU(d, power[0][c].data() + i),
                     hn::Mul(time, hn::LoadU(d, power[1][c].data() + i)));
    });
  }
  const size_t curved = Padded(vertices.linear);
  for (size_t i = curved; i < curved + vertices.count - vertices.linear; i += lanes) {
    const size_t k = i - curved;
    const auto tau = hn::Add(hn::Mul(time, hn::LoadU(d, vertices.time_scale.data() + k)),
                             hn::LoadU(d, vertices.time_offset.data() + k));
    place(i, [&](int c) HWY_ATTR {
      auto sum = hn::LoadU(d, power[3][c].data() + i);
      for (int p = 2; p >= 0; --p) sum = hn::Add(hn::LoadU(d, power[p][c].data() + i), hn::Mul(tau, sum));
      return sum;
    });
  }
}

inline void PlaceTrianglesKernel(const GroupTriangles& triangles, const PlacedVertices& vertices, double t,
                                 int lanes, int32_t length, PlacedTriangles& out) {
  const Doubles d;
  const hn::Rebind<int32_t, Doubles> i32;
  const hn::Rebind<int64_t, Doubles> i64;
  const hn::Rebind<float, Doubles> f32;
  const size_t n = hn::Lanes(d);
  const auto zero = hn::Zero(d);
  const auto one = hn::Set(d, 1.0);
  const auto time = hn::Set(d, t);
  const auto last_lane = hn::Set(d, double(lanes - 1));
  const auto line_end = hn::Set(d, double(length));

  for (size_t i = 0; i < triangles.count; i += n) {
    uint8_t* const met = out.met.data() + i;
    uint8_t* const clipped = out.clipped.data() + i;
    for (size_t k = 0; k < n; ++k) met[k] = clipped[k] = 0;
    const auto in_time = hn::And(hn::Le(hn::LoadU(d, triangles.t_in.data() + i), time),
                                 hn::Ge(hn::LoadU(d, triangles.t_out.data() + i), time));
    if (hn::AllFalse(d, in_time)) continue;

    DoublesV row[3], position[3], depth[3];
    for (int k = 0; k < 3; ++k) {
      const auto at = hn::PromoteTo(i64, hn::LoadU(i32, triangles.vertex[k].data() + i));
      row[k] = hn::GatherIndex(d, vertices.row.data(), at);
      position[k] = hn::GatherIndex(d, vertices.position.data(), at);
      depth[k] = hn::GatherIndex(d, vertices.depth.data(), at);
    }
    const auto nan = hn::IsNaN(hn::Add(hn::Add(row[0], row[1]), row[2]));
    const auto usable = hn::AndNot(nan, in_time);
    const auto to_clip = hn::And(nan, in_time);

    // Which way it faces, before the corners are sorted.
    const auto area = hn::Sub(hn::Mul(hn::Sub(row[1], row[0]), hn::Sub(position[2], position[0])),
                              hn::Mul(hn::Sub(row[2], row[0]), hn::Sub(position[1], position[0])));
    const auto away = hn::Lt(hn::Mul(area, hn::LoadU(d, triangles.facing.data() + i)), zero);

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

    // Lanes strictly above the lowest corner up to the highest, see the convention for f = 0.
    const auto first = hn::Max(zero, hn::Add(hn::Floor(row[0]), one));
    const auto last = hn::Min(last_lane, hn::Floor(row[2]));
    const auto least = hn::Min(position[0], hn::Min(position[1], position[2]));
    const auto most = hn::Max(position[0], hn::Max(position[1], position[2]));
    const auto meets = hn::And(hn::AndNot(away, hn::Le(first, last)),
                               hn::And(hn::Gt(most, zero), hn::Lt(least, line_end)));
    const auto all = hn::And(meets, usable);

    uint8_t bits[8] = {0};
    hn::StoreMaskBits(d, to_clip, bits);
    uint8_t met_bits[8] = {0};
    hn::StoreMaskBits(d, all, met_bits);
    for (size_t k = 0; k < n; ++k) {
      clipped[k] = uint8_t(bits[0] >> k & 1);
      met[k] = uint8_t(met_bits[0] >> k & 1);
    }
    if (met_bits[0] == 0) continue;

    const auto store = [&](DoublesV v, std::vector<double>& to) HWY_ATTR { hn::StoreU(v, d, to.data() + i); };
    const auto store_float = [&](DoublesV v, std::vector<float>& to)
                                 HWY_ATTR { hn::StoreU(hn::DemoteTo(f32, v), f32, to.data() + i); };
    store(row[0], out.row_a);
    store(row[1], out.row_b);
    store(hn::Div(one, hn::Sub(row[2], row[0])), out.inverse_ac);
    store(hn::Div(one, hn::Sub(row[1], row[0])), out.inverse_ab);
    store(hn::Div(one, hn::Sub(row[2], row[1])), out.inverse_bc);
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
    hn::StoreU(hn::DemoteTo(i32, first), i32, out.first_lane.data() + i);
    hn::StoreU(hn::DemoteTo(i32, last), i32, out.last_lane.data() + i);
    hn::StoreU(hn::DemoteTo(i32, hn::Max(hn::Sub(least, one), zero)), i32, out.least.data() + i);
    hn::StoreU(hn::DemoteTo(i32, hn::Min(hn::Add(most, one), hn::Sub(line_end, one))), i32,
               out.most.data() + i);
  }
}

inline const char* TargetName() { return hwy::TargetName(HWY_TARGET); }

}  // namespace HWY_NAMESPACE
}  // namespace shutterline::engine
HWY_AFTER_NAMESPACE();

#endif
