#include "worker/engine/stochastic/pass_raster.h"

#include <bit>
#include <cmath>

// akenine2007, section 3: triangles whose edge functions depend on time, tested at samples each of which has
// a time of its own. What differs: the time strata are the outer loop and bound the triangles, samples are
// tested 16 at a time, and depth is culled by block and pass.

// Instruction sets older than AVX2 have no fused multiplication and addition: they run the portable code, as
// cmake/Dependencies.cmake says.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "worker/engine/stochastic/pass_raster.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "worker/engine/stochastic/block_cull-inl.h"
#include "worker/engine/stochastic/block_test-inl.h"
#include "worker/engine/stochastic/pass_bounds-inl.h"
#include "worker/engine/stochastic/pass_samples-inl.h"

HWY_BEFORE_NAMESPACE();
namespace shutterline::engine {
namespace HWY_NAMESPACE {

/// From so many blocks on it pays to ask which of them a triangle touches.
constexpr int kManyBlocks = 6;

/// Tests one triangle against the blocks of its bounds.
template <int kDegree, bool kConstantZ>
HWY_ATTR void TestTriangle(const CellTriangles& cell, uint32_t index, uint32_t bounds, const Pass& pass,
                           const PassRange& range, PassBuffers& buffers, PassCounts& counts) {
  const DF d;
  const PassShape& shape = pass.shape;
  const CellTriangle& triangle = cell.triangles[index];
  const int per_side = shape.blocks_per_side();
  const int x0 = int(bounds & 0xff), x1 = int(bounds >> 8 & 0xff);
  const int y0 = int(bounds >> 16 & 0xff), y1 = int(bounds >> 24);
  if ((x1 - x0 + 1) * (y1 - y0 + 1) < kManyBlocks) {
    for (int y = y0; y <= y1; ++y) {
      for (int x = x0; x <= x1; ++x) {
        const int block = y * per_side + x;
        if (triangle.nearest_depth < buffers.farthest[size_t(block)]) continue;
        TestBlock<kDegree, kConstantZ>(cell, index, shape, block, buffers, counts);
      }
    }
    return;
  }
  const float side = float(shape.block()) / kCellSize;
  const EdgeBounds<kDegree> edges(triangle, cell.coefficients.data() + triangle.first_coefficient, range,
                                  side);
  for (int y = y0; y <= y1; ++y) {
    const VF center_y = hn::Set(d, (float(y) + 0.5f) * side);
    for (int x = x0; x <= x1; x += int(hn::Lanes(d))) {
      const VF column = hn::Add(hn::Iota(d, float(x)), hn::Set(d, 0.5f));
      MF touched = edges.MayTouch(hn::Mul(column, hn::Set(d, side)), center_y, triangle.cull_back);
      touched = hn::And(touched, hn::FirstN(d, size_t(x1 - x + 1)));
      uint8_t bytes[8] = {};
      hn::StoreMaskBits(d, touched, bytes);
      for (uint32_t bits = bytes[0] | uint32_t{bytes[1]} << 8; bits != 0; bits &= bits - 1) {
        const int block = y * per_side + x + std::countr_zero(bits);
        if (triangle.nearest_depth < buffers.farthest[size_t(block)]) continue;
        TestBlock<kDegree, kConstantZ>(cell, index, shape, block, buffers, counts);
      }
    }
  }
}

template <bool kConstantZ>
HWY_ATTR void TestTriangles(const CellTriangles& cell, size_t active, const Pass& pass,
                            const PassRange& range, PassBuffers& buffers, PassCounts& counts) {
  for (size_t i = 0; i < active; ++i) {
    const uint32_t index = buffers.active[i], bounds = buffers.blocks[i];
    switch (cell.triangles[index].degree) {
      case 0:
        TestTriangle<0, true>(cell, index, bounds, pass, range, buffers, counts);
        break;
      case 1:
        TestTriangle<1, kConstantZ>(cell, index, bounds, pass, range, buffers, counts);
        break;
      case 2:
        TestTriangle<2, kConstantZ>(cell, index, bounds, pass, range, buffers, counts);
        break;
      default:
        TestTriangle<3, kConstantZ>(cell, index, bounds, pass, range, buffers, counts);
    }
  }
}

HWY_ATTR PassCounts Rasterize(const CellTriangles& cell, const Pass& pass, PassBuffers& buffers) {
  const PassRange range(pass);
  const PassShape& shape = pass.shape;
  // Below every depth that is visible, so that what lies at the far plane is seen.
  const float background = std::nextafter(cell.far_depth * (1 - 1e-6f), -1.0f);
  const LaneTables lanes(pass, background);
  for (int y = range.y0; y <= range.y1; ++y) {
    for (int x = range.x0; x <= range.x1; ++x) {
      MakeBlockSamples(pass, lanes, x, y, buffers);
      buffers.farthest[size_t(y * shape.blocks_per_side() + x)] = background;
    }
  }

  size_t active = 0;
  switch (cell.degree) {
    case 0:
      active = CollectActive<0>(cell, range, shape, buffers);
      break;
    case 1:
      active = CollectActive<1>(cell, range, shape, buffers);
      break;
    case 2:
      active = CollectActive<2>(cell, range, shape, buffers);
      break;
    default:
      active = CollectActive<3>(cell, range, shape, buffers);
  }

  PassCounts counts;
  counts.visited = int64_t(active);
  if (cell.constant_z) {
    TestTriangles<true>(cell, active, pass, range, buffers, counts);
  } else {
    TestTriangles<false>(cell, active, pass, range, buffers, counts);
  }
  return counts;
}

}  // namespace HWY_NAMESPACE
}  // namespace shutterline::engine
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace shutterline::engine {

HWY_EXPORT(Rasterize);

PassBuffers::PassBuffers() {
  constexpr size_t kSamples = size_t{kCellSize} * kCellSize * kMostPassStrata;
  for (auto* floats : {&x, &y, &tau, &depth, &b1, &b2}) {
    *floats = hwy::AllocateAligned<float>(kSamples);
  }
  seen = hwy::AllocateAligned<uint32_t>(kSamples);
  for (auto* keys : {&key_a, &key_b, &key_c, &key_t}) keys->resize(kCellSize * kCellSize);
  farthest.resize(kCellSize * kCellSize);
}

PassCounts RasterizePass(const CellTriangles& cell, const Pass& pass, PassBuffers& buffers) {
  return HWY_DYNAMIC_DISPATCH(Rasterize)(cell, pass, buffers);
}

}  // namespace shutterline::engine
#endif  // HWY_ONCE
