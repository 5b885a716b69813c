// Compiled once for each instruction set: see pass_raster.cpp.
#if defined(SHUTTERLINE_PASS_BOUNDS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SHUTTERLINE_PASS_BOUNDS_INL_H_
#undef SHUTTERLINE_PASS_BOUNDS_INL_H_
#else
#define SHUTTERLINE_PASS_BOUNDS_INL_H_
#endif

#include <hwy/highway.h>

#include "worker/engine/stochastic/pass_raster.h"
#include "worker/engine/stochastic/vector_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace shutterline::engine {
namespace HWY_NAMESPACE {

/// Where a pass lies: tau from `begin` to `end`, blocks [x0, x1] × [y0, y1].
struct PassRange {
  float begin = -1, end = 1;
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;

  explicit PassRange(const Pass& pass) {
    const int last = pass.first_stratum + pass.shape.strata;
    begin = float(TauOf(double(pass.first_stratum) / pass.spp));
    end = float(TauOf(double(last < pass.spp ? last : pass.spp) / pass.spp));
    const int log2 = pass.shape.block_log2;
    x0 = pass.x0 >> log2;
    y0 = pass.y0 >> log2;
    x1 = (pass.x1 - 1) >> log2;
    y1 = (pass.y1 - 1) >> log2;
  }
};

/// The control points on [a, b] of polynomials given by powers, one a lane.
template <int kDegree>
HWY_INLINE HWY_ATTR void ControlPoints(const VF (&c)[kDegree + 1], VF a, VF b, VF (&points)[kDegree + 1]) {
  [[maybe_unused]] const DF d;
  if constexpr (kDegree == 0) {
    points[0] = c[0];
  } else {
    VF at_a = c[kDegree], at_b = c[kDegree];
    for (int i = kDegree - 1; i >= 0; --i) {
      at_a = hn::MulAdd(at_a, a, c[i]);
      at_b = hn::MulAdd(at_b, b, c[i]);
    }
    points[0] = at_a;
    points[kDegree] = at_b;
    if constexpr (kDegree >= 2) {
      VF slope_a = hn::Mul(hn::Set(d, float(kDegree)), c[kDegree]), slope_b = slope_a;
      for (int i = kDegree - 1; i >= 1; --i) {
        const VF term = hn::Mul(hn::Set(d, float(i)), c[i]);
        slope_a = hn::MulAdd(slope_a, a, term);
        slope_b = hn::MulAdd(slope_b, b, term);
      }
      const VF step = hn::Mul(hn::Sub(b, a), hn::Set(d, 1 / float(kDegree)));
      points[1] = hn::MulAdd(slope_a, step, at_a);
      if constexpr (kDegree == 3) points[2] = hn::NegMulAdd(slope_b, step, at_b);
    }
  }
}

/// Finds the triangles that a pass may see, and their blocks: the projections of a moving vertex lie among
/// those of its control points for that part of the shutter, while all of these are in front of the eye.
template <int kDegree>
HWY_ATTR size_t CollectActive(const CellTriangles& cell, const PassRange& range, const PassShape& shape,
                              PassBuffers& buffers) {
  const DF d;
  const DU du;
  const DI di;
  const size_t count = cell.triangles.size();
  buffers.active.resize(cell.stride + kVectorSamples);
  buffers.blocks.resize(cell.stride + kVectorSamples);
  const auto per_side = float(shape.blocks_per_side());
  const VF scale = hn::Set(d, per_side);
  const VF x_first = hn::Set(d, float(range.x0)), x_last = hn::Set(d, float(range.x1));
  const VF y_first = hn::Set(d, float(range.y0)), y_last = hn::Set(d, float(range.y1));
  const VF one = hn::Set(d, 1.0f);
  // Rounding moves positions in the cell by far less than 1e-4 of it, and others by their share of `reach`.
  const VF slack = hn::Set(d, 1e-4f), relative_slack = hn::Set(d, 2e-6f);
  const VF minus_one = hn::Set(d, -1.0f), begin = hn::Set(d, range.begin), end = hn::Set(d, range.end);
  size_t found = 0;
  for (size_t i = 0; i < count; i += hn::Lanes(d)) {
    VF x_low = hn::Set(d, 1e30f), x_high = hn::Set(d, -1e30f), y_low = x_low, y_high = x_high;
    VF most = hn::Zero(d), least_w = one;
    // The part of the pass in which the piece is there.
    const VF time_scale = hn::LoadU(d, cell.time_scale.data() + i);
    const VF time_offset = hn::LoadU(d, cell.time_offset.data() + i);
    const VF u_begin = hn::Max(hn::MulAdd(begin, time_scale, time_offset), minus_one);
    const VF u_end = hn::Min(hn::MulAdd(end, time_scale, time_offset), one);
    for (int vertex = 0; vertex < 3; ++vertex) {
      VF control[3][kDegree + 1];
      for (int axis = 0; axis < 3; ++axis) {
        VF c[kDegree + 1];
        for (int power = 0; power <= kDegree; ++power) {
          c[power] = hn::LoadU(d, cell.Path(vertex, axis, power) + i);
        }
        ControlPoints<kDegree>(c, u_begin, u_end, control[axis]);
      }
      for (int j = 0; j <= kDegree; ++j) {
        const VF w = control[2][j];
        // The processor's approximation, made better by one step of Newton's.
        VF inverse = hn::ApproximateReciprocal(w);
        inverse = hn::Mul(inverse, hn::NegMulAdd(w, inverse, hn::Set(d, 2.0f)));
        const VF x = hn::Mul(control[0][j], inverse), y = hn::Mul(control[1][j], inverse);
        x_low = hn::Min(x_low, x);
        x_high = hn::Max(x_high, x);
        y_low = hn::Min(y_low, y);
        y_high = hn::Max(y_high, y);
        most = hn::Max(most, inverse);
        least_w = hn::Min(least_w, w);
      }
    }
    const VF grow = hn::MulAdd(hn::Mul(relative_slack, hn::LoadU(d, cell.reach.data() + i)), most, slack);
    // Behind the eye, or so close to its plane that projections are far out: it may be anywhere.
    const MF anywhere = hn::Not(hn::Gt(least_w, hn::Set(d, 1e-5f)));
    const VF x0 = hn::IfThenElse(anywhere, x_first, hn::Mul(hn::Sub(x_low, grow), scale));
    const VF x1 = hn::IfThenElse(anywhere, x_last, hn::Mul(hn::Add(x_high, grow), scale));
    const VF y0 = hn::IfThenElse(anywhere, y_first, hn::Mul(hn::Sub(y_low, grow), scale));
    const VF y1 = hn::IfThenElse(anywhere, y_last, hn::Mul(hn::Add(y_high, grow), scale));
    const MF in_x = hn::And(hn::Ge(x1, x_first), hn::Le(x0, hn::Add(x_last, one)));
    const MF in_y = hn::And(hn::Ge(y1, y_first), hn::Le(y0, hn::Add(y_last, one)));
    const MF valid = hn::FirstN(d, count - i);
    // Samples at a joint may be rounded into either piece.
    const MF in_time = hn::Le(u_begin, hn::Add(u_end, hn::Set(d, 1e-4f)));
    const MF in = hn::And(hn::And(valid, in_time), hn::And(in_x, in_y));
    const auto block = [&](VF v, VF first, VF last) HWY_ATTR {
      return hn::BitCast(du, hn::ConvertTo(di, hn::Min(hn::Max(v, first), last)));
    };
    const VU columns = hn::Or(block(x0, x_first, x_last), hn::ShiftLeft<8>(block(x1, x_first, x_last)));
    const VU rows = hn::Or(block(y0, y_first, y_last), hn::ShiftLeft<8>(block(y1, y_first, y_last)));
    const auto in_u = hn::RebindMask(du, in);
    hn::CompressStore(hn::Or(columns, hn::ShiftLeft<16>(rows)), in_u, du, buffers.blocks.data() + found);
    found += hn::CompressStore(hn::Iota(du, uint32_t(i)), in_u, du, buffers.active.data() + found);
  }
  return found;
}

}  // namespace HWY_NAMESPACE
}  // namespace shutterline::engine
HWY_AFTER_NAMESPACE();

#endif
