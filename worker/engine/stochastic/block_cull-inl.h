// Compiled once for each instruction set: see pass_raster.cpp.
#if defined(SHUTTERLINE_BLOCK_CULL_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SHUTTERLINE_BLOCK_CULL_INL_H_
#undef SHUTTERLINE_BLOCK_CULL_INL_H_
#else
#define SHUTTERLINE_BLOCK_CULL_INL_H_
#endif

#include <hwy/highway.h>

#include "worker/engine/stochastic/pass_bounds-inl.h"
#include "worker/engine/stochastic/vector_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace shutterline::engine {
namespace HWY_NAMESPACE {

/// Edge functions of a triangle over a pass, turned to its front: Bernstein coefficients in time, each affine
/// in x and y, between the least and largest of which the function stays.
template <int kDegree>
class EdgeBounds {
 public:
  static constexpr int kEdgeDegree = 2 * kDegree;

  HWY_ATTR EdgeBounds(const CellTriangle& triangle, const float* coefficients, const PassRange& range,
                      float block_side) {
    const float begin = range.begin * triangle.time_scale + triangle.time_offset;
    const float end = range.end * triangle.time_scale + triangle.time_offset;
    for (int k = 0; k < 3; ++k) {
      const float sign = triangle.edge_signs[size_t(k)] != 0 ? -1.0f : 1.0f;
      const float* edge = coefficients + k * 3 * (kEdgeDegree + 1);
      float rounding = 0;
      for (int i = 0; i < 3 * (kEdgeDegree + 1); ++i) rounding += std::abs(edge[i]);
      rounding *= 4e-6f;
      for (int component = 0; component < 3; ++component) {
        float p[kEdgeDegree + 1];
        for (int i = 0; i <= kEdgeDegree; ++i) p[i] = sign * edge[3 * i + component];
        ToBernstein(p, begin < -1 ? -1 : begin, end > 1 ? 1 : end);
        for (int i = 0; i <= kEdgeDegree; ++i) at_[k][i][component] = p[i];
      }
      for (int i = 0; i <= kEdgeDegree; ++i) {
        const float slope = std::abs(at_[k][i][0]) + std::abs(at_[k][i][1]);
        radius_[k][i] = 0.5f * block_side * slope + rounding;
      }
    }
  }

  /// Of blocks with the given centres, those that front or back may touch.
  HWY_ATTR MF MayTouch(VF x, VF y, bool cull_back) const {
    const DF d;
    const VF zero = hn::Zero(d);
    MF front_out = hn::FirstN(d, 0), back_out = front_out;
    for (int k = 0; k < 3; ++k) {
      VF high = hn::Set(d, -1e30f), low = hn::Set(d, 1e30f);
      for (int i = 0; i <= kEdgeDegree; ++i) {
        const float* abc = at_[k][i];
        const VF radius = hn::Set(d, radius_[k][i]);
        const VF value =
            hn::MulAdd(hn::Set(d, abc[0]), x, hn::MulAdd(hn::Set(d, abc[1]), y, hn::Set(d, abc[2])));
        high = hn::Max(high, hn::Add(value, radius));
        low = hn::Min(low, hn::Sub(value, radius));
      }
      front_out = hn::Or(front_out, hn::Lt(high, zero));
      back_out = hn::Or(back_out, hn::Gt(low, zero));
    }
    return hn::Not(cull_back ? front_out : hn::And(front_out, back_out));
  }

 private:
  /// From powers of tau to Bernstein coefficients on [begin, end].
  static HWY_ATTR void ToBernstein(float (&p)[kEdgeDegree + 1], float begin, float end) {
    constexpr int n = kEdgeDegree;
    // Taylor's coefficients at `begin`, by repeated synthetic division, scaled to the interval.
    for (int i = 0; i < n; ++i) {
      for (int j = n - 1; j >= i; --j) p[j] += p[j + 1] * begin;
    }
    float scale = 1;
    for (int i = 0; i <= n; ++i, scale *= end - begin) p[i] *= scale / float(Binomial(n, i));
    // b_i = sum of C(i, j) times them.
    for (int i = 0; i < n; ++i) {
      for (int j = n; j > i; --j) p[j] += p[j - 1];
    }
  }
  static constexpr int Binomial(int n, int k) {
    int result = 1;
    for (int i = 0; i < k; ++i) result = result * (n - i) / (i + 1);
    return result;
  }

  float at_[3][kEdgeDegree + 1][3];
  float radius_[3][kEdgeDegree + 1];
};

}  // namespace HWY_NAMESPACE
}  // namespace shutterline::engine
HWY_AFTER_NAMESPACE();

#endif
