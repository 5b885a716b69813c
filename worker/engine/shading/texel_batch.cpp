#include "worker/engine/shading/texel_batch.h"

// As the resolver's kernels, see slice/kernels.cpp: the same bits on every instruction set.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "worker/engine/shading/texel_batch.cpp"
#include <hwy/foreach_target.h>
// The order matters: Highway's loop above includes this file once for each instruction set.
#include <hwy/highway.h>

#include <limits>

HWY_BEFORE_NAMESPACE();
namespace shutterline::engine {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using TexelDoubles = hn::CappedTag<double, 8>;
using TexelDoublesV = hn::Vec<TexelDoubles>;

/// 2 to the power of LevelFor(squared), for numbers in [kLeastRise, infinity).
HWY_INLINE TexelDoublesV CellsFor(TexelDoublesV squared) {
  const TexelDoubles d;
  const hn::RebindToUnsigned<TexelDoubles> du;
  const auto exponent = hn::ShiftRight<52>(hn::BitCast(du, hn::Add(squared, squared)));
  // The level is (1 - (exponent - 1023)) >> 1, here with 1024 on top so that it is never negative.
  const auto level = hn::ShiftRight<1>(hn::Sub(hn::Set(du, 3072), exponent));
  const auto from_zero = hn::Max(level, hn::Set(du, 1024));
  return hn::BitCast(d, hn::ShiftLeft<52>(hn::Sub(from_zero, hn::Set(du, 1))));
}

inline void FindLevels(TexelBatch& batch) {
  const TexelDoubles d;
  const auto least = hn::Set(d, kLeastTexelRise);
  const auto infinity = hn::Set(d, std::numeric_limits<double>::infinity());
  const auto most_cells = hn::Set(d, double(uint64_t{1} << Texel::kMaxLevelSum));
  alignas(64) double columns[8], rows[8];
  for (size_t k = 0; k < batch.uneven_count; k += hn::Lanes(d)) {
    const auto over = hn::Div(hn::Set(d, 1.0), hn::LoadU(d, batch.uneven_over_w.data() + k));
    const auto w = hn::Mul(hn::LoadU(d, batch.w.data() + k), over);
    const auto scale = hn::Mul(w, over);
    const auto scale2 = hn::Mul(scale, scale);
    const auto squared1 = hn::Mul(hn::LoadU(d, batch.squared1.data() + k), scale2);
    const auto squared2 = hn::Mul(hn::LoadU(d, batch.squared2.data() + k), scale2);
    const auto low = hn::Min(squared1, squared2), high = hn::Max(squared1, squared2);
    const auto fits = hn::And(hn::And(hn::Ge(low, least), hn::Lt(high, infinity)), hn::Gt(w, hn::Zero(d)));
    const auto c = CellsFor(squared1), r = CellsFor(squared2);
    const auto has_key = hn::Le(hn::Mul(c, r), most_cells);
    hn::Store(hn::IfThenElseZero(hn::And(fits, has_key), c), d, columns);
    hn::Store(r, d, rows);
    for (size_t n = k; n < std::min(k + hn::Lanes(d), batch.uneven_count); ++n) {
      batch.columns[batch.uneven[n]] = columns[n - k];
      batch.rows[batch.uneven[n]] = rows[n - k];
    }
  }
}

inline void FindTexelsKernel(TexelBatch& batch) {
  FindLevels(batch);
  const TexelDoubles d;
  const hn::Rebind<int32_t, TexelDoubles> di;
  const auto zero = hn::Zero(d), one = hn::Set(d, 1.0);
  // Not a number is none of them, so these are zero then.
  const auto clamped = [&](TexelDoublesV x, TexelDoublesV most) {
    return hn::IfThenElseZero(hn::Gt(x, zero), hn::Min(x, most));
  };
  for (size_t k = 0; k < batch.count; k += hn::Lanes(d)) {
    const auto over = hn::Div(one, hn::Load(d, batch.one_over_w.data() + k));
    const auto b1 = clamped(hn::Mul(hn::Load(d, batch.b1.data() + k), over), one);
    const auto b2 = clamped(hn::Mul(hn::Load(d, batch.b2.data() + k), over), hn::Sub(one, b1));
    hn::Store(b1, d, batch.b1.data() + k);
    hn::Store(b2, d, batch.b2.data() + k);
    const auto columns = hn::Load(d, batch.columns.data() + k), rows = hn::Load(d, batch.rows.data() + k);
    auto i = hn::Min(hn::Floor(hn::Mul(b1, columns)), hn::Sub(columns, one));
    auto j = hn::Min(hn::Floor(hn::Mul(b2, rows)), hn::Sub(rows, one));
    // A point on the long side may have got into a texel that only touches it.
    const auto beyond = hn::Ge(hn::Add(hn::Mul(i, rows), hn::Mul(j, columns)), hn::Mul(columns, rows));
    const auto step = hn::IfThenElseZero(beyond, one);
    const auto left = hn::Gt(i, zero);
    i = hn::Sub(i, hn::IfThenElseZero(left, step));
    j = hn::Sub(j, hn::IfThenZeroElse(left, step));
    hn::Store(hn::DemoteTo(di, i), di, batch.i.data() + k);
    hn::Store(hn::DemoteTo(di, j), di, batch.j.data() + k);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace shutterline::engine
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace shutterline::engine {

HWY_EXPORT(FindTexelsKernel);

void FindTexels(TexelBatch& batch) {
  HWY_DYNAMIC_DISPATCH(FindTexelsKernel)(batch);
}

}  // namespace shutterline::engine
#endif
