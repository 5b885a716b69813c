#pragma once

#include <bit>
#include <cstdint>
#include <cstring>

#include "common/math/spaces.h"

/// Four floats in a vector of the processor. Arithmetic is that of single floats, so results are the same on
/// all of them. A vector extension that GCC and Clang share.
namespace shutterline::engine {

using Float4 = float __attribute__((vector_size(16)));

inline V4f ToV4f(Float4 v) {
  return {v[0], v[1], v[2], v[3]};
}

inline Float4 Float4Of(const uint16_t* codes) {
  using Long2 = uint64_t __attribute__((vector_size(16)));
  using Short8 = uint16_t __attribute__((vector_size(16)));
  using Int4 = int32_t __attribute__((vector_size(16)));
  // By way of an integer, as compilers are apt to put halves of vectors together in memory.
  uint64_t four = 0;
  std::memcpy(&four, codes, sizeof(four));
  const auto low = std::bit_cast<Short8>(Long2{four, 0});
  // With zeros in between, shorts are ints.
  constexpr bool kLittle = std::endian::native == std::endian::little;
  const Short8 zero{};
  const Short8 wide = kLittle ? __builtin_shufflevector(low, zero, 0, 8, 1, 9, 2, 10, 3, 11)
                              : __builtin_shufflevector(zero, low, 0, 8, 1, 9, 2, 10, 3, 11);
  return __builtin_convertvector(std::bit_cast<Int4>(wide), Float4);
}

/// Exact where both ends are equal, so that a constant image stays constant.
inline Float4 Mix(Float4 a, Float4 b, float part) {
  return a + part * (b - a);
}

}  // namespace shutterline::engine
