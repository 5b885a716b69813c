// Vectors of space, one a lane. Included once per instruction set, by shade_kernels.cpp. Everything is
// computed by the operations of the plain code in its order, so that it has the same bits.
#if defined(SHUTTERLINE_SHADE_VECTORS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SHUTTERLINE_SHADE_VECTORS_INL_H
#undef SHUTTERLINE_SHADE_VECTORS_INL_H
#else
#define SHUTTERLINE_SHADE_VECTORS_INL_H
#endif

#include <hwy/highway.h>

#include "common/math/spaces.h"
#include "worker/engine/shading/surface_batch.h"

HWY_BEFORE_NAMESPACE();
namespace shutterline::engine {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using ShadeTag = hn::CappedTag<double, 8>;
using ShadeFloats = hn::Rebind<float, ShadeTag>;
using ShadeInts = hn::Rebind<int32_t, ShadeTag>;
using Doubles = hn::Vec<ShadeTag>;
using DoublesMask = hn::Mask<ShadeTag>;

struct Doubles3 {
  Doubles x, y, z;
};

HWY_INLINE Doubles All(double value) {
  return hn::Set(ShadeTag(), value);
}
HWY_INLINE Doubles3 All(const V3d& v) {
  return {All(v.x), All(v.y), All(v.z)};
}
HWY_INLINE Doubles At(const SurfaceBatch::Array<double>& values, size_t k) {
  return hn::Load(ShadeTag(), values.data() + k);
}
HWY_INLINE Doubles At(const SurfaceBatch::Array<float>& values, size_t k) {
  return hn::PromoteTo(ShadeTag(), hn::Load(ShadeFloats(), values.data() + k));
}
template <typename Arrays>
HWY_INLINE Doubles3 At3(const Arrays& values, size_t first, size_t k) {
  return {At(values[first], k), At(values[first + 1], k), At(values[first + 2], k)};
}

HWY_INLINE Doubles3 operator+(const Doubles3& a, const Doubles3& b) {
  return {hn::Add(a.x, b.x), hn::Add(a.y, b.y), hn::Add(a.z, b.z)};
}
HWY_INLINE Doubles3 operator-(const Doubles3& a, const Doubles3& b) {
  return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}
HWY_INLINE Doubles3 operator*(const Doubles3& a, const Doubles3& b) {
  return {hn::Mul(a.x, b.x), hn::Mul(a.y, b.y), hn::Mul(a.z, b.z)};
}
HWY_INLINE Doubles3 Times(Doubles s, const Doubles3& v) {
  return {hn::Mul(s, v.x), hn::Mul(s, v.y), hn::Mul(s, v.z)};
}
HWY_INLINE Doubles Dot(const Doubles3& a, const Doubles3& b) {
  return hn::Add(hn::Add(hn::Mul(a.x, b.x), hn::Mul(a.y, b.y)), hn::Mul(a.z, b.z));
}
HWY_INLINE Doubles3 Cross(const Doubles3& a, const Doubles3& b) {
  return {hn::Sub(hn::Mul(a.y, b.z), hn::Mul(a.z, b.y)), hn::Sub(hn::Mul(a.z, b.x), hn::Mul(a.x, b.z)),
          hn::Sub(hn::Mul(a.x, b.y), hn::Mul(a.y, b.x))};
}
HWY_INLINE Doubles3 Negative(const Doubles3& v) {
  return {hn::Neg(v.x), hn::Neg(v.y), hn::Neg(v.z)};
}
HWY_INLINE Doubles3 Choose(DoublesMask mask, const Doubles3& yes, const Doubles3& no) {
  return {hn::IfThenElse(mask, yes.x, no.x), hn::IfThenElse(mask, yes.y, no.y),
          hn::IfThenElse(mask, yes.z, no.z)};
}

/// From one number to another.
template <typename Numbers>
HWY_INLINE Numbers Between(Numbers a, Numbers b, Numbers part) {
  return hn::Add(a, hn::Mul(part, hn::Sub(b, a)));
}

/// std::max, std::min and std::clamp, what they do with what is not a number included.
HWY_INLINE Doubles Greater(Doubles a, Doubles b) {
  return hn::IfThenElse(hn::Lt(a, b), b, a);
}
HWY_INLINE Doubles Lesser(Doubles a, Doubles b) {
  return hn::IfThenElse(hn::Lt(b, a), b, a);
}
HWY_INLINE Doubles Clamped(Doubles x, Doubles low, Doubles high) {
  return hn::IfThenElse(hn::Lt(x, low), low, hn::IfThenElse(hn::Lt(high, x), high, x));
}

/// UnitOrZero of vectors of which it need not look closely; adds the others to `odd`.
HWY_INLINE Doubles3 Unit(const Doubles3& v, DoublesMask& odd) {
  const Doubles square = Dot(v, v);
  odd = hn::Or(odd, hn::Not(hn::And(hn::Gt(square, All(1e-200)), hn::Lt(square, All(1e200)))));
  const Doubles length = hn::Sqrt(square);
  return {hn::Div(v.x, length), hn::Div(v.y, length), hn::Div(v.z, length)};
}

}  // namespace HWY_NAMESPACE
}  // namespace shutterline::engine
HWY_AFTER_NAMESPACE();

#endif
