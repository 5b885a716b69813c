// Compiled once for each instruction set: see pass_raster.cpp.
#if defined(SHUTTERLINE_BLOCK_TEST_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SHUTTERLINE_BLOCK_TEST_INL_H_
#undef SHUTTERLINE_BLOCK_TEST_INL_H_
#else
#define SHUTTERLINE_BLOCK_TEST_INL_H_
#endif

#include <hwy/highway.h>

#include "worker/engine/stochastic/pass_bounds-inl.h"
#include "worker/engine/stochastic/pass_raster.h"
#include "worker/engine/stochastic/vector_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace shutterline::engine {
namespace HWY_NAMESPACE {

/// For each of a sample's three edge functions, turned to the triangle's front.
struct EdgeValues {
  VF e[3];
};

template <int kDegree>
HWY_INLINE HWY_ATTR EdgeValues EvaluateEdges(const CellTriangle& triangle, const float* c, VF x, VF y, VF u) {
  const DF d;
  const DU du;
  EdgeValues values;
  for (int k = 0; k < 3; ++k) {
    const float* edge = c + k * 3 * (2 * kDegree + 1);
    VF e = hn::Zero(d);
    for (int power = 2 * kDegree; power >= 0; --power) {
      const float* abc = edge + 3 * power;
      const VF affine = Fma(hn::Set(d, abc[0]), x, Fma(hn::Set(d, abc[1]), y, hn::Set(d, abc[2])));
      e = power == 2 * kDegree ? affine : Fma(e, u, affine);
    }
    values.e[k] = hn::Xor(e, hn::BitCast(d, hn::Set(du, triangle.edge_signs[size_t(k)])));
  }
  return values;
}

/// Depths z/w where a sample is inside: edge functions weigh the vertices, all with one sign, so sums do not
/// cancel and a depth lies among those of the vertices.
template <int kDegree, bool kConstantZ>
HWY_INLINE HWY_ATTR VF EvaluateDepth(const float* c, const EdgeValues& edges, VF u) {
  const DF d;
  const float* w = c + 9 * (2 * kDegree + 1);
  if constexpr (kDegree == 0) {
    const VF last = hn::Mul(edges.e[2], hn::Set(d, w[2]));
    return Fma(edges.e[0], hn::Set(d, w[0]), Fma(edges.e[1], hn::Set(d, w[1]), last));
  } else {
    constexpr int kStep = kDegree + 1;
    const float* z = w + 3 * kStep;
    VF w_sum = hn::Mul(edges.e[2], Polynomial<kDegree>(w + 2 * kStep, u));
    w_sum = Fma(edges.e[1], Polynomial<kDegree>(w + kStep, u), w_sum);
    w_sum = Fma(edges.e[0], Polynomial<kDegree>(w, u), w_sum);
    constexpr int kZDegree = kConstantZ ? 0 : kDegree;
    VF z_sum = hn::Mul(edges.e[2], Polynomial<kZDegree>(z + 2 * kStep, u));
    z_sum = Fma(edges.e[1], Polynomial<kZDegree>(z + kStep, u), z_sum);
    z_sum = Fma(edges.e[0], Polynomial<kZDegree>(z, u), z_sum);
    return hn::Div(z_sum, w_sum);
  }
}

/// Of samples as near as what they see already, those whose triangle has the lower number.
HWY_NOINLINE HWY_ATTR MF WinTies(const CellTriangles& cell, uint32_t id, MF ties, const uint32_t* seen) {
  const DF d;
  const DU du;
  HWY_ALIGN uint32_t lower[kVectorSamples];
  for (size_t i = 0; i < hn::Lanes(d); ++i) {
    lower[i] = seen[i] != 0 && id < cell.triangles[seen[i] - 1].id ? ~0u : 0;
  }
  return hn::And(ties, hn::RebindMask(d, hn::Ne(hn::Load(du, lower), hn::Zero(du))));
}

/// Barycentric coordinates of vertices 1 and 2, as Shade takes them, to the lanes that see the triangle.
HWY_INLINE HWY_ATTR void StorePositions(const CellTriangle& triangle, const EdgeValues& edges, MF visible,
                                        float* b1, float* b2) {
  const DF d;
  const VF p1 = hn::Mul(edges.e[1], hn::Set(d, triangle.barycentric_scale[1]));
  const VF p2 = hn::Mul(edges.e[2], hn::Set(d, triangle.barycentric_scale[2]));
  const VF sum = Fma(edges.e[0], hn::Set(d, triangle.barycentric_scale[0]), hn::Add(p1, p2));
  const VF inverse = hn::Div(hn::Set(d, 1.0f), sum);
  hn::BlendedStore(hn::Mul(p1, inverse), visible, d, b1);
  hn::BlendedStore(hn::Mul(p2, inverse), visible, d, b2);
}

/// Tests all samples of a block in a pass against a triangle.
template <int kDegree, bool kConstantZ>
HWY_ATTR void TestBlock(const CellTriangles& cell, uint32_t index, const PassShape& shape, int block,
                        PassBuffers& buffers, PassCounts& counts) {
  const DF d;
  const DU du;
  const DI di;
  const CellTriangle& triangle = cell.triangles[index];
  const float* c = cell.coefficients.data() + triangle.first_coefficient;
  const size_t begin = size_t(block) * size_t(shape.vectors()) * kVectorSamples;
  const size_t end = begin + size_t(shape.vectors()) * kVectorSamples;
  const auto zero = hn::Zero(di);
  [[maybe_unused]] const VF time_scale = hn::Set(d, triangle.time_scale);
  [[maybe_unused]] const VF time_offset = hn::Set(d, triangle.time_offset);
  bool changed = false;
  for (size_t at = begin; at < end; at += hn::Lanes(d)) {
    [[maybe_unused]] VF u = hn::Zero(d);
    if constexpr (kDegree > 0) u = Fma(hn::Load(d, buffers.tau.get() + at), time_scale, time_offset);
    const EdgeValues edges = EvaluateEdges<kDegree>(triangle, c, hn::Load(d, buffers.x.get() + at),
                                                    hn::Load(d, buffers.y.get() + at), u);
    // A zero counts by its sign bit: both neighbours along an edge compute the same one.
    const VF some_negative = hn::Or(hn::Or(edges.e[0], edges.e[1]), edges.e[2]);
    auto inside_i = hn::Not(hn::Lt(hn::BitCast(di, some_negative), zero));
    if (!triangle.cull_back) {
      const VF all_negative = hn::And(hn::And(edges.e[0], edges.e[1]), edges.e[2]);
      inside_i = hn::Or(inside_i, hn::Lt(hn::BitCast(di, all_negative), zero));
    }
    if (hn::AllFalse(di, inside_i)) continue;
    ++counts.hit;
    MF inside = hn::RebindMask(d, inside_i);
    if (kDegree > 0 && triangle.partial) {
      inside = hn::And(inside, hn::And(hn::Ge(u, hn::Set(d, -1.0f)), hn::Le(u, hn::Set(d, 1.0f))));
    }
    const VF depth = EvaluateDepth<kDegree, kConstantZ>(c, edges, u);
    const VF nearest = hn::Load(d, buffers.depth.get() + at);
    // What lies behind the eye has a negative depth, which is behind the background too.
    MF visible = hn::And(inside, hn::And(hn::Gt(depth, nearest), hn::Le(depth, hn::Set(d, 1.0f))));
    const MF ties = hn::And(inside, hn::Eq(depth, nearest));
    uint32_t* const seen = buffers.seen.get() + at;
    if (!hn::AllFalse(d, ties)) visible = hn::Or(visible, WinTies(cell, triangle.id, ties, seen));
    if (hn::AllFalse(d, visible)) continue;
    changed = true;
    hn::BlendedStore(depth, visible, d, buffers.depth.get() + at);
    hn::BlendedStore(hn::Set(du, index + 1), hn::RebindMask(du, visible), du, seen);
    if (triangle.needs_position) {
      StorePositions(triangle, edges, visible, buffers.b1.get() + at, buffers.b2.get() + at);
    }
  }
  counts.tested += shape.vectors();
  if (!changed) return;
  VF farthest = hn::Load(d, buffers.depth.get() + begin);
  for (size_t at = begin + hn::Lanes(d); at < end; at += hn::Lanes(d)) {
    farthest = hn::Min(farthest, hn::Load(d, buffers.depth.get() + at));
  }
  buffers.farthest[size_t(block)] = hn::GetLane(hn::MinOfLanes(d, farthest));
}

}  // namespace HWY_NAMESPACE
}  // namespace shutterline::engine
HWY_AFTER_NAMESPACE();

#endif
