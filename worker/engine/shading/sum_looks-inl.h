// What the walks of a batch see of textures. Included once per instruction set, by shade_kernels.cpp.
#if defined(SHUTTERLINE_SUM_LOOKS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef SHUTTERLINE_SUM_LOOKS_INL_H
#undef SHUTTERLINE_SUM_LOOKS_INL_H
#else
#define SHUTTERLINE_SUM_LOOKS_INL_H
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <type_traits>

#include "worker/engine/scene/float4.h"
#include "worker/engine/scene/mip_pyramid.h"
#include "worker/engine/shading/batch_looks.h"
#include "worker/engine/shading/shade_kernels.h"

HWY_BEFORE_NAMESPACE();
namespace shutterline::engine {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// The channels of two texels: an upper one's, then those of the one below it. Results by reference: how such
/// vectors are returned depends on the instruction set.
using Float8 = float __attribute__((vector_size(32)));

/// The codes of two texels as numbers. By way of integers: compilers are apt to put halves of vectors
/// together in memory, and to wait for it.
template <typename Code>
HWY_INLINE void ToFloats(const Code* upper, const Code* lower, Float8& to) {
#if HWY_MAX_BYTES >= 32
  using Half = hn::FixedTag<Code, 4>;
  using Bits = std::conditional_t<sizeof(Code) == 1, uint32_t, uint64_t>;
  const auto load = [](const Code* codes) HWY_ATTR {
    Bits bits;
    std::memcpy(&bits, codes, sizeof(bits));
    return hn::BitCast(Half(), hn::Set(hn::FixedTag<Bits, 1>(), bits));
  };
  const auto codes = hn::Combine(hn::FixedTag<Code, 8>(), load(lower), load(upper));
  to = hn::ConvertTo(hn::FixedTag<float, 8>(), hn::PromoteTo(hn::FixedTag<int32_t, 8>(), codes)).raw;
#else
  for (int c = 0; c < 4; ++c) {
    to[c] = float(upper[c]);
    to[4 + c] = float(lower[c]);
  }
#endif
}

/// Read the values of two texels, times kScale: linear ones, of bytes or shorts.
template <typename Code>
struct LinearTexels {
  static constexpr float kScale = sizeof(Code) == 1 ? 1 : 65535;  ///< Of shorts only the sum is divided.
  const Code* codes;

  explicit LinearTexels(const Code* of_image) : codes(of_image) {}
  HWY_INLINE void ReadTwo(int32_t upper, int32_t lower, Float8& to) const {
    ToFloats(codes + 4 * size_t(upper), codes + 4 * size_t(lower), to);
    if constexpr (sizeof(Code) == 1) to /= 255.f;
  }
};
/// The same of codes of sRGB.
template <typename Code>
struct SrgbTexels {
  static constexpr float kScale = 1;
  const Code* codes;
  const float* color;

  SrgbTexels(const Code* of_image, const float* by_code) : codes(of_image), color(by_code) {}
  HWY_INLINE void ReadTwo(int32_t upper, int32_t lower, Float8& to) const {
    constexpr float kMost = std::numeric_limits<Code>::max();
    const Code* const a = codes + 4 * size_t(upper);
    const Code* const b = codes + 4 * size_t(lower);
    to = Float8{color[a[0]], color[a[1]], color[a[2]], float(a[3]) / kMost,
                color[b[0]], color[b[1]], color[b[2]], float(b[3]) / kMost};
  }
};

/// MipPyramid::Sum of the looks of point i.
template <typename Texels>
HWY_INLINE Float4 SumOf(const Texels& texels, std::span<const BatchLook> looks, size_t i) {
  Float4 sum{};
  for (const BatchLook& look : looks) {
    Float8 left, right;
    texels.ReadTwo(look.top_left[i], look.bottom_left[i], left);
    texels.ReadTwo(look.top_right[i], look.bottom_right[i], right);
    const Float8 rows = left + look.right[i] * (right - left);
    const Float4 top = __builtin_shufflevector(rows, rows, 0, 1, 2, 3);
    const Float4 bottom = __builtin_shufflevector(rows, rows, 4, 5, 6, 7);
    sum += Mix(top, bottom, look.down[i]);
  }
  return sum / Texels::kScale;
}

HWY_INLINE Float4 SumAt(const TexelCodes& codes, std::span<const BatchLook> looks, size_t i) {
  switch (codes.kind) {
    case TexelCodes::Kind::kShorts:
      return SumOf(LinearTexels(codes.shorts), looks, i);
    case TexelCodes::Kind::kBytes:
      return SumOf(LinearTexels(codes.bytes), looks, i);
    case TexelCodes::Kind::kSrgbBytes:
      return SumOf(SrgbTexels(codes.bytes, codes.color), looks, i);
    case TexelCodes::Kind::kSrgbShorts:
      return SumOf(SrgbTexels(codes.shorts, codes.color), looks, i);
  }
  return Float4{};
}

/// Has memory send what point i looks at. Inlined: compilers drop calls of functions that do nothing else.
HWY_INLINE void TellMemory(const TexelCodes& codes, std::span<const BatchLook> looks, size_t i) {
  // What lies to the right is mostly in the same line of the cache.
  for (const BatchLook& look : looks) {
    __builtin_prefetch(codes.AddressOf(size_t(look.top_left[i])));
    __builtin_prefetch(codes.AddressOf(size_t(look.bottom_left[i])));
  }
}

/// Looks of a point at a level, and at the next one if it is in between.
struct PointLooks {
  int level;
  float between;
  std::span<const BatchLook> fine, coarse;

  PointLooks(const BatchWalks& walks, const SurfaceBatch& batch, size_t i)
      : level(batch.level[i]), between(batch.between[i]) {
    const auto count = size_t(std::max(batch.probes[i], 1));
    fine = {walks.fine.data(), count};
    if (between > 0) coarse = {walks.coarse.data(), count};
  }
};

HWY_INLINE void TellMemory(std::span<const LookedAt> textures, const BatchWalks& walks,
                           const SurfaceBatch& batch, size_t i) {
  if (i >= batch.count) return;
  const PointLooks looks(walks, batch, i);
  for (const LookedAt& texture : textures) {
    TellMemory(texture.pyramid->CodesOf(looks.level), looks.fine, i);
    if (looks.between > 0) TellMemory(texture.pyramid->CodesOf(looks.level + 1), looks.coarse, i);
  }
}

/// TextureWalk::Sample.
inline void SumLooksKernel(std::span<const LookedAt> textures, const BatchWalks& walks, SurfaceBatch& batch) {
  // Textures are larger than caches. Any small number will do.
  constexpr size_t kAhead = 3;
  for (size_t i = 0; i < kAhead; ++i) TellMemory(textures, walks, batch, i);
  for (size_t i = 0; i < batch.count; ++i) {
    TellMemory(textures, walks, batch, i + kAhead);
    const PointLooks looks(walks, batch, i);
    for (const LookedAt& texture : textures) {
      Float4 sum = SumAt(texture.pyramid->CodesOf(looks.level), looks.fine, i);
      if (looks.between > 0) {
        sum = Mix(sum, SumAt(texture.pyramid->CodesOf(looks.level + 1), looks.coarse, i), looks.between);
      }
      if (looks.fine.size() > 1) sum /= float(looks.fine.size());
      auto& texels = batch.texels[texture.slot];
      for (size_t c = 0; c < 4; ++c) texels[c][i] = sum[c];
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace shutterline::engine
HWY_AFTER_NAMESPACE();

#endif
