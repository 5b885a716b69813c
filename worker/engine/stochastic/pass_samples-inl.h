// Compiled once for each instruction set: see pass_raster.cpp.
#if defined(SHUTTERLINE_PASS_SAMPLES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SHUTTERLINE_PASS_SAMPLES_INL_H_
#undef SHUTTERLINE_PASS_SAMPLES_INL_H_
#else
#define SHUTTERLINE_PASS_SAMPLES_INL_H_
#endif

#include <hwy/highway.h>

#include <limits>

#include "worker/engine/stochastic/pass_raster.h"
#include "worker/engine/stochastic/vector_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace shutterline::engine {
namespace HWY_NAMESPACE {

#if HWY_TARGET == HWY_SCALAR
HWY_INLINE HWY_ATTR VU ScrambledPositions(VU digits, VU a, VU b, VU c) {
  return hn::Set(DU(), ScrambleHalves(hn::GetLane(digits), hn::GetLane(a), hn::GetLane(b), hn::GetLane(c)));
}
#else
/// Reverses the bits of each half of each lane.
HWY_INLINE HWY_ATTR VU ReverseHalves(VU v) {
  const DU d;
  const hn::Repartition<uint16_t, DU> d16;
  const hn::Repartition<uint8_t, DU> d8;
  HWY_ALIGN static constexpr uint8_t kNibbles[16] = {0x0, 0x8, 0x4, 0xc, 0x2, 0xa, 0x6, 0xe,
                                                     0x1, 0x9, 0x5, 0xd, 0x3, 0xb, 0x7, 0xf};
  const auto table = hn::LoadDup128(d8, kNibbles);
  const auto nibble = hn::Set(d8, uint8_t{0x0f});
  const auto v16 = hn::BitCast(d16, v);
  const auto low = hn::And(hn::BitCast(d8, v16), nibble);
  const auto high = hn::And(hn::BitCast(d8, hn::ShiftRight<4>(v16)), nibble);
  const auto low_reversed = hn::BitCast(d16, hn::TableLookupBytes(table, low));
  const auto high_reversed = hn::BitCast(d16, hn::TableLookupBytes(table, high));
  const auto bytes = hn::Or(hn::ShiftLeft<4>(low_reversed), high_reversed);
  return hn::BitCast(d, hn::Or(hn::ShiftLeft<8>(bytes), hn::ShiftRight<8>(bytes)));
}

/// Owen's scrambling of two strings of 16 reversed digits a lane: Scramble of sample_keys.h.
HWY_INLINE HWY_ATTR VU ScrambleVector(VU digits, VU a, VU b, VU c) {
  const DU d;
  const hn::Repartition<uint16_t, DU> d16;
  const auto key_a = hn::BitCast(d16, a), key_c = hn::BitCast(d16, c);
  const auto odd = hn::Or(hn::BitCast(d16, b), hn::Set(d16, uint16_t{1}));
  const auto even = hn::And(key_c, hn::Set(d16, uint16_t{0xfffe}));
  auto v = hn::BitCast(d16, digits);
  v = hn::Xor(v, hn::Mul(v, hn::Set(d16, uint16_t(kScrambleFirst & 0xffff))));
  v = hn::Mul(hn::Add(v, key_a), odd);
  v = hn::Xor(v, hn::Mul(v, hn::Set(d16, uint16_t(kScrambleSecond & 0xffff))));
  v = hn::Xor(v, hn::Mul(v, even));
  v = hn::Add(v, key_c);
  v = hn::Xor(v, hn::Mul(v, hn::Set(d16, uint16_t(kScrambleThird & 0xffff))));
  return hn::BitCast(d, v);
}

/// ScrambleHalves of sample_keys.h for every lane.
HWY_INLINE HWY_ATTR VU ScrambledPositions(VU digits, VU a, VU b, VU c) {
  return ReverseHalves(ScrambleVector(digits, a, b, c));
}
#endif

/// Keys of a block's lanes: a block holds 16, 4 or 1 pixels, whose keys repeat for each stratum.
HWY_INLINE HWY_ATTR VU LoadKeys(const uint32_t* keys, int block_log2, size_t lane) {
  const DU d;
  if (block_log2 == 2) return hn::LoadU(d, keys + lane);
#if HWY_TARGET == HWY_SCALAR
  if (block_log2 == 1) return hn::Load(d, keys + lane % 4);
#else
  if (block_log2 == 1) return hn::LoadDup128(d, keys);
#endif
  return hn::Set(d, *keys);
}

/// Lanes of a vector that do not depend on the block: place in it, and what their strata are.
struct LaneTables {
  HWY_ALIGN float x[kVectorSamples];
  HWY_ALIGN float y[kVectorSamples];
  HWY_ALIGN uint32_t digits[kMostPassStrata * kVectorSamples];
  HWY_ALIGN uint32_t mixed[kMostPassStrata * kVectorSamples];
  HWY_ALIGN float stratum[kMostPassStrata * kVectorSamples];
  HWY_ALIGN float depth[kMostPassStrata * kVectorSamples];

  LaneTables(const Pass& pass, float background) {
    const int log2 = pass.shape.block_log2, mask = pass.shape.block() - 1;
    for (int lane = 0; lane < kVectorSamples; ++lane) {
      // To the pixel's corner, half a step of the digits is added.
      x[lane] = (float(lane & mask) + 0x1p-17f) / kCellSize;
      y[lane] = (float(lane >> log2 & mask) + 0x1p-17f) / kCellSize;
      for (int v = 0; v < pass.shape.vectors(); ++v) {
        const int s = pass.first_stratum + v * pass.shape.vector_strata() + (lane >> (2 * log2));
        const int i = v * kVectorSamples + lane;
        digits[i] = StratifiedPattern::Digits(s);
        mixed[i] = uint32_t(s) * kTimeMultiplier;
        stratum[i] = float(s);
        depth[i] = s < pass.spp ? background : std::numeric_limits<float>::infinity();
      }
    }
  }
};

/// Writes the samples of a block, and the background to all of them.
HWY_INLINE HWY_ATTR void MakeBlockSamples(const Pass& pass, const LaneTables& lanes, int bx, int by,
                                          PassBuffers& buffers) {
  const DF df;
  const DU du;
  const DI di;
  const PassShape& shape = pass.shape;
  const int block = by * shape.blocks_per_side() + bx;
  const size_t key = size_t(block) << (2 * shape.block_log2);
  const float side = float(shape.block()) / kCellSize;
  const VF step = hn::Set(df, 0x1p-16f / kCellSize);
  const VF time_step = hn::Set(df, 2.0f / float(pass.spp));
  for (size_t lane = 0; lane < size_t{kVectorSamples}; lane += hn::Lanes(df)) {
    const VU a = LoadKeys(buffers.key_a.data() + key, shape.block_log2, lane);
    const VU b = LoadKeys(buffers.key_b.data() + key, shape.block_log2, lane);
    const VU c = LoadKeys(buffers.key_c.data() + key, shape.block_log2, lane);
    const VU t = LoadKeys(buffers.key_t.data() + key, shape.block_log2, lane);
    const VF x0 = hn::Add(hn::Load(df, lanes.x + lane), hn::Set(df, float(bx) * side));
    const VF y0 = hn::Add(hn::Load(df, lanes.y + lane), hn::Set(df, float(by) * side));
    for (int v = 0; v < shape.vectors(); ++v) {
      const size_t from = size_t(v) * kVectorSamples + lane;
      const size_t to = (size_t(block) * size_t(shape.vectors()) + size_t(v)) * kVectorSamples + lane;
      const VU position = ScrambledPositions(hn::Load(du, lanes.digits + from), a, b, c);
      const auto x = hn::BitCast(di, hn::And(position, hn::Set(du, 0xffffu)));
      const auto y = hn::BitCast(di, hn::ShiftRight<16>(position));
      hn::Store(Fma(hn::ConvertTo(df, x), step, x0), df, buffers.x.get() + to);
      hn::Store(Fma(hn::ConvertTo(df, y), step, y0), df, buffers.y.get() + to);
      VU h = hn::Xor(t, hn::Load(du, lanes.mixed + from));
      h = hn::Mul(hn::Xor(h, hn::ShiftRight<15>(h)), hn::Set(du, kTimeMixer));
      h = hn::Xor(h, hn::ShiftRight<13>(h));
      const VF within = hn::ConvertTo(df, hn::BitCast(di, hn::ShiftRight<8>(h)));
      const VF time = Fma(within, hn::Set(df, 0x1p-24f), hn::Load(df, lanes.stratum + from));
      hn::Store(Fma(time, time_step, hn::Set(df, -1.0f)), df, buffers.tau.get() + to);
      hn::Store(hn::Load(df, lanes.depth + from), df, buffers.depth.get() + to);
      hn::Store(hn::Zero(du), du, buffers.seen.get() + to);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace shutterline::engine
HWY_AFTER_NAMESPACE();

#endif
