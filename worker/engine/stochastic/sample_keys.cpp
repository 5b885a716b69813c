#include "worker/engine/stochastic/sample_keys.h"

#include <array>
#include <cstddef>

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

/// The direction numbers of Sobol's second dimension (polynomial x + 1), digits reversed.
constexpr std::array<uint32_t, 16> MakeDirections() {
  std::array<uint32_t, 16> directions{};
  uint32_t m = 1;
  for (int k = 0; k < 16; ++k) {
    for (int j = 0; j <= k; ++j) {
      if (m >> (k - j) & 1) directions[std::size_t(k)] |= uint32_t{1} << j;
    }
    m ^= m << 1;
  }
  return directions;
}
constexpr std::array<uint32_t, 16> kDirections = MakeDirections();

}  // namespace

StratifiedPattern::StratifiedPattern(uint64_t seed, int64_t frame, int spp)
    : frame_key_(Mix(Mix(seed) * 0x9fb21c651e98df25u + uint64_t(frame))), spp_(spp) {}

SampleKeys StratifiedPattern::Keys(int x, int y, int stratum) const {
  const uint64_t pixel = Mix(frame_key_ + (uint64_t(uint32_t(x)) << 32 | uint32_t(y)));
  const uint64_t first = Mix(pixel + uint64_t(uint32_t(stratum) >> 16) * 0x632be59bd9b4e019u);
  const uint64_t second = Mix(first ^ 0xd1b54a32d192ed03u);
  return {uint32_t(first), uint32_t(first >> 32), uint32_t(second), uint32_t(second >> 32)};
}

uint32_t StratifiedPattern::Digits(int stratum) {
  const auto index = uint32_t(stratum) & 0xffff;
  uint32_t y = 0;
  for (uint32_t bit = 0; index >> bit != 0; ++bit) {
    if (index >> bit & 1) y ^= kDirections[bit];
  }
  return y << 16 | index;
}

StratifiedPoint StratifiedPattern::At(int x, int y, int stratum) const {
  const SampleKeys keys = Keys(x, y, stratum);
  const uint32_t digits = Digits(stratum);
  const uint32_t scrambled = ScrambleHalves(digits, keys.a, keys.b, keys.c);
  const auto position = [&](int shift) { return (float(scrambled >> shift & 0xffff) + 0.5f) * 0x1p-16f; };
  uint32_t h = keys.t ^ uint32_t(stratum) * kTimeMultiplier;
  h = (h ^ h >> 15) * kTimeMixer;
  h ^= h >> 13;
  const float within = float(h >> 8) * 0x1p-24f;
  return {position(0), position(16), float((double(stratum) + double(within)) / spp_)};
}

}  // namespace shutterline::engine
