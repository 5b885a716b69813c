// Compiled once for each instruction set: see pass_raster.cpp.
#if defined(SHUTTERLINE_VECTOR_MATH_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SHUTTERLINE_VECTOR_MATH_INL_H_
#undef SHUTTERLINE_VECTOR_MATH_INL_H_
#else
#define SHUTTERLINE_VECTOR_MATH_INL_H_
#endif

#include <hwy/highway.h>

#include <cmath>

#include "worker/engine/stochastic/cell.h"

HWY_BEFORE_NAMESPACE();
namespace shutterline::engine {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using DF = hn::CappedTag<float, kVectorSamples>;
using DU = hn::Rebind<uint32_t, DF>;
using DI = hn::Rebind<int32_t, DF>;
using VF = hn::Vec<DF>;
using VU = hn::Vec<DU>;
using MF = hn::Mask<DF>;

/// a * b + c, rounded once, whatever the processor: what a picture depends on must not be written as MulAdd,
/// which rounds twice where there is no such instruction.
HWY_INLINE HWY_ATTR VF Fma(VF a, VF b, VF c) {
#if HWY_NATIVE_FMA
  return hn::MulAdd(a, b, c);
#else
  const DF d;
  HWY_ALIGN float p[kVectorSamples];
  HWY_ALIGN float q[kVectorSamples];
  HWY_ALIGN float r[kVectorSamples];
  hn::Store(a, d, p);
  hn::Store(b, d, q);
  hn::Store(c, d, r);
  for (size_t i = 0; i < hn::Lanes(d); ++i) r[i] = std::fma(p[i], q[i], r[i]);
  return hn::Load(d, r);
#endif
}

/// A polynomial, the same for all lanes, its coefficients from the constant one on.
template <int kDegree>
HWY_INLINE HWY_ATTR VF Polynomial(const float* c, VF t) {
  const DF d;
  VF sum = hn::Set(d, c[kDegree]);
  for (int i = kDegree - 1; i >= 0; --i) sum = Fma(sum, t, hn::Set(d, c[i]));
  return sum;
}

}  // namespace HWY_NAMESPACE
}  // namespace shutterline::engine
HWY_AFTER_NAMESPACE();

#endif
