// Footprints and WalkPlans of a batch. Included once per instruction set, by shade_kernels.cpp.
#if defined(SHUTTERLINE_PLAN_WALKS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SHUTTERLINE_PLAN_WALKS_INL_H
#undef SHUTTERLINE_PLAN_WALKS_INL_H
#else
#define SHUTTERLINE_PLAN_WALKS_INL_H
#endif

#include <hwy/highway.h>

#include "worker/engine/shading/shade_vectors-inl.h"
#include "worker/engine/shading/texture_walk.h"

HWY_BEFORE_NAMESPACE();
namespace shutterline::engine {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// PixelFootprint.
inline void MeasureFootprintsKernel(SurfaceBatch& batch) {
  const ShadeTag d;
  for (size_t k = 0; k < batch.count; k += hn::Lanes(d)) {
    const Doubles b1 = At(batch.b1, k), b2 = At(batch.b2, k);
    // x, y, w as if they were x, y, z.
    const Doubles3 first = At3(batch.raster, 0, k);
    const Doubles3 edge1 = At3(batch.raster, 3, k) - first, edge2 = At3(batch.raster, 6, k) - first;
    const Doubles3 p = first + (Times(b1, edge1) + Times(b2, edge2));
    const Doubles x = hn::Div(p.x, p.z), y = hn::Div(p.y, p.z);
    const auto derivative = [&](Doubles edge, Doubles at, Doubles edge_w) {
      return hn::Div(hn::Sub(edge, hn::Mul(at, edge_w)), p.z);
    };
    const Doubles dx_db1 = derivative(edge1.x, x, edge1.z), dx_db2 = derivative(edge2.x, x, edge2.z);
    const Doubles dy_db1 = derivative(edge1.y, y, edge1.z), dy_db2 = derivative(edge2.y, y, edge2.z);
    const Doubles determinant = hn::Sub(hn::Mul(dx_db1, dy_db2), hn::Mul(dx_db2, dy_db1));
    const Doubles made[] = {hn::Div(dy_db2, determinant), hn::Div(hn::Neg(dx_db2), determinant),
                            hn::Div(hn::Neg(dy_db1), determinant), hn::Div(dx_db1, determinant)};
    DoublesMask is_seen = hn::Gt(p.z, hn::Zero(d));
    for (const Doubles of : made) is_seen = hn::And(is_seen, hn::IsFinite(of));
    for (size_t i = 0; i < 4; ++i) {
      hn::Store(hn::IfThenElseZero(is_seen, made[i]), d, batch.footprint[i].data() + k);
    }
  }
}

/// The function of that name.
HWY_INLINE Doubles Log2(Doubles x) {
  const ShadeTag d;
  const hn::RebindToUnsigned<ShadeTag> du;
  const auto bits = hn::BitCast(du, x);
  // Numbers below 2^52 are exact where the ones of that power are taken for the least.
  const Doubles huge = All(4503599627370496.0);
  const Doubles biased =
      hn::Sub(hn::BitCast(d, hn::Or(hn::ShiftRight<52>(bits), hn::BitCast(du, huge))), huge);
  Doubles exponent = hn::Sub(biased, All(1023));
  const auto mantissa = hn::And(bits, hn::Set(du, (uint64_t{1} << 52) - 1));
  Doubles m = hn::BitCast(d, hn::Or(mantissa, hn::Set(du, uint64_t{1023} << 52)));
  const DoublesMask is_large = hn::Gt(m, All(1.4142135623730951));
  m = hn::IfThenElse(is_large, hn::Mul(m, All(0.5)), m);
  exponent = hn::Add(exponent, hn::IfThenElseZero(is_large, All(1)));
  const Doubles one = All(1);
  const Doubles s = hn::Div(hn::Sub(m, one), hn::Add(m, one)), s2 = hn::Mul(s, s);
  Doubles series = All(1.0 / 9);
  for (const double term : {1.0 / 7, 1.0 / 5, 1.0 / 3, 1.0}) series = hn::Add(All(term), hn::Mul(s2, series));
  return hn::Add(exponent, hn::Mul(hn::Mul(s, series), All(2 / M_LN2)));
}

/// WalkPlan::Make.
inline void PlanWalksKernel(const WalkedImage& image, int most_probes, SurfaceBatch& batch) {
  const ShadeTag d;
  const ShadeInts di;
  const Doubles one = All(1), zero = hn::Zero(d);
  const Doubles width = All(image.width), height = All(image.height), most = All(most_probes);
  for (size_t k = 0; k < batch.count; k += hn::Lanes(d)) {
    const Doubles b1 = At(batch.b1, k), b2 = At(batch.b2, k);
    const auto& uv = batch.coordinates;
    const Doubles u1 = At(uv[2], k), v1 = At(uv[3], k), u2 = At(uv[4], k), v2 = At(uv[5], k);
    const auto mapped = [&](Doubles along1, Doubles along2, Doubles of1, Doubles of2) {
      return hn::Add(hn::Mul(along1, of1), hn::Mul(along2, of2));
    };
    const Doubles u = hn::Add(hn::Add(At(uv[0], k), hn::Mul(b1, u1)), hn::Mul(b2, u2));
    const Doubles v = hn::Add(hn::Add(At(uv[1], k), hn::Mul(b1, v1)), hn::Mul(b2, v2));
    const auto& by = batch.footprint;
    const Doubles du_dx = mapped(At(by[0], k), At(by[2], k), u1, u2);
    const Doubles dv_dx = mapped(At(by[0], k), At(by[2], k), v1, v2);
    const Doubles du_dy = mapped(At(by[1], k), At(by[3], k), u1, u2);
    const Doubles dv_dy = mapped(At(by[1], k), At(by[3], k), v1, v2);

    const Doubles sxx = hn::Mul(du_dx, width), sxy = hn::Mul(dv_dx, height);
    const Doubles syx = hn::Mul(du_dy, width), syy = hn::Mul(dv_dy, height);
    const Doubles square_x = hn::Add(hn::Mul(sxx, sxx), hn::Mul(sxy, sxy));
    const Doubles square_y = hn::Add(hn::Mul(syx, syx), hn::Mul(syy, syy));
    const Doubles square = Greater(square_x, square_y);
    const DoublesMask is_wide = hn::Gt(square, one);

    const DoublesMask finite = hn::And(hn::IsFinite(square_x), hn::IsFinite(square_y));
    const Doubles longest = hn::Sqrt(square);
    const Doubles area = hn::Abs(hn::Sub(hn::Mul(sxx, syy), hn::Mul(sxy, syx)));
    const Doubles ratio = hn::Sub(hn::Div(longest, Greater(hn::Div(area, longest), one)), All(1e-6));
    const Doubles whole = hn::Floor(ratio);
    const Doubles next = hn::Add(whole, hn::IfThenElseZero(hn::Gt(ratio, whole), one));
    const Doubles by_ratio = hn::IfThenElse(hn::Lt(ratio, most), Clamped(next, one, most), most);
    const Doubles probes = hn::IfThenElse(finite, by_ratio, one);
    const Doubles texels =
        hn::IfThenElse(finite, Greater(hn::Div(square, hn::Mul(probes, probes)), one), square);
    // Not looked at where the footprint is small, and there it may be anything.
    const Doubles safe = hn::IfThenElse(is_wide, texels, one);
    const Doubles lod = Lesser(hn::Mul(All(0.5), Log2(safe)), All(image.LastLevel()));
    const Doubles level = hn::Floor(lod);

    hn::Store(hn::IfThenElseZero(hn::IsFinite(u), u), d, batch.u.data() + k);
    hn::Store(hn::IfThenElseZero(hn::IsFinite(v), v), d, batch.v.data() + k);
    const DoublesMask along_x = hn::Ge(square_x, square_y);
    const Doubles step_u = hn::Div(hn::IfThenElse(along_x, du_dx, du_dy), probes);
    const Doubles step_v = hn::Div(hn::IfThenElse(along_x, dv_dx, dv_dy), probes);
    hn::Store(hn::IfThenElse(is_wide, step_u, zero), d, batch.step_u.data() + k);
    hn::Store(hn::IfThenElse(is_wide, step_v, zero), d, batch.step_v.data() + k);
    hn::Store(hn::DemoteTo(di, hn::IfThenElseZero(is_wide, probes)), di, batch.probes.data() + k);
    hn::Store(hn::DemoteTo(di, level), di, batch.level.data() + k);
    hn::Store(hn::DemoteTo(ShadeFloats(), hn::Sub(lod, level)), ShadeFloats(), batch.between.data() + k);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace shutterline::engine
HWY_AFTER_NAMESPACE();

#endif
