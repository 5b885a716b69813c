#include "worker/engine/sampling/point_pattern.h"

// burley2020: "Practical Hash-based Owen Scrambling". What is taken from it is the observation that sums,
// products with odd numbers and x ^ (x * even) carry information only from lower bits to higher ones, so
// that on a number whose bits are reversed they are a nested scrambling. The rounds and keys are our own,
// with 64 bits of key a dimension; there is no shuffling of the index, because all three dimensions belong
// to one sequence.

namespace shutterline::engine {
namespace {

/// A bijection of 64 bits in which every input bit changes about half of the output.
uint64_t Mix(uint64_t v) {
  v ^= v >> 32;
  v *= 0xe9846af9b1a615d5u;
  v ^= v >> 31;
  v *= 0x9e6c63d0676a9a99u;
  v ^= v >> 29;
  return v;
}

uint64_t Combine(uint64_t key, uint64_t value) {
  return Mix(key * 0x9fb21c651e98df25u + Mix(value + 0x632be59bd9b4e019u));
}

uint32_t ReverseBits(uint32_t v) {
  v = (v >> 16) | (v << 16);
  v = ((v >> 8) & 0x00ff00ffu) | ((v & 0x00ff00ffu) << 8);
  v = ((v >> 4) & 0x0f0f0f0fu) | ((v & 0x0f0f0f0fu) << 4);
  v = ((v >> 2) & 0x33333333u) | ((v & 0x33333333u) << 2);
  return ((v >> 1) & 0x55555555u) | ((v & 0x55555555u) << 1);
}

using Directions = std::array<uint32_t, 32>;

/// The direction numbers of one dimension, bits reversed: bit 0 of each is the binary digit ½. They follow
/// from a primitive polynomial x^s + a_1 x^(s-1) + ... + a_(s-1) x + 1 (`inner` holds a_1 ... a_(s-1), a_1
/// highest) and the first s odd numbers m_k < 2^k by Sobol's recurrence.
constexpr Directions MakeDirections(int degree, unsigned inner, std::array<uint32_t, 2> first) {
  std::array<uint64_t, 32> m{};
  for (int k = 0; k < 32; ++k) {
    if (k < degree) {
      m[k] = first[k];
      continue;
    }
    m[k] = m[k - degree] ^ (m[k - degree] << degree);
    for (int i = 1; i < degree; ++i) {
      if (inner >> (degree - 1 - i) & 1) m[k] ^= m[k - i] << i;
    }
  }
  // m_k / 2^(k+1) is the direction; reversed, its digit 2^-(j+1) is bit j.
  Directions directions{};
  for (int k = 0; k < 32; ++k) {
    for (int j = 0; j <= k; ++j) {
      if (m[k] >> (k - j) & 1) directions[k] |= uint32_t{1} << j;
    }
  }
  return directions;
}

/// Van der Corput's sequence: every m is 1.
constexpr Directions MakeVanDerCorput() {
  Directions directions{};
  for (int k = 0; k < 32; ++k) directions[k] = uint32_t{1} << k;
  return directions;
}

/// Van der Corput, x + 1, x² + x + 1: the three simplest.
constexpr std::array<Directions, 3> kDirections{MakeVanDerCorput(), MakeDirections(1, 0, {1, 0}),
                                                MakeDirections(2, 1, {1, 3})};

/// One scrambling round on reversed bits: bit i of the result depends on bits 0 to i of `v`, and is that
/// bit or its complement as the lower bits and the key decide.
uint32_t ScrambleRound(uint32_t v, uint64_t key) {
  const auto low = uint32_t(key), high = uint32_t(key >> 32);
  v += low;
  v ^= v * (high & ~uint32_t{1});
  v *= (low >> 16 | low << 16) | 1;
  return v;
}

double Coordinate(uint32_t reversed, uint64_t key) {
  const uint32_t scrambled = ScrambleRound(ScrambleRound(reversed, key), Mix(key));
  return ReverseBits(scrambled) * 0x1p-32;
}

}  // namespace

PixelPoints::Digits PixelPoints::DigitsOf(uint32_t index) {
  Digits digits{};
  for (int bit = 0; index != 0; ++bit, index >>= 1) {
    const uint32_t mask = -(index & 1);
    for (int d = 0; d < 3; ++d) digits[d] ^= kDirections[d][bit] & mask;
  }
  return digits;
}

PixelPoint PixelPoints::At(const Digits& digits) const {
  return {Coordinate(digits[0], keys_[0]), Coordinate(digits[1], keys_[1]), Coordinate(digits[2], keys_[2])};
}

PointPattern::PointPattern(uint64_t seed, int64_t frame) : frame_key_(Combine(Mix(seed), uint64_t(frame))) {}

PixelPoints PointPattern::Pixel(int x, int y) const {
  const uint64_t pixel = Combine(frame_key_, uint64_t(uint32_t(x)) << 32 | uint32_t(y));
  return PixelPoints({Combine(pixel, 1), Combine(pixel, 2), Combine(pixel, 3)});
}

}  // namespace shutterline::engine
