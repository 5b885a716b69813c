#pragma once

#include <cstdint>
#include <vector>

namespace shutterline::engine {

/// A point of a pixel and the shutter; x and y from the pixel's top left corner, all in [0, 1).
struct StratifiedPoint {
  float x = 0, y = 0, t = 0;
};

/// Random numbers of one pixel; they choose its samples.
struct SampleKeys {
  uint32_t a = 0, b = 0, c = 0;  ///< Halves: the lower for x, the upper for y.
  uint32_t t = 0;
};

/// The samples of a frame: `spp` points a pixel, point s in stratum [s, s + 1) / spp of the shutter, at an
/// independent uniform time within it; x and y are the first spp points of the (0, 2)-sequence of van der
/// Corput and Sobol' under Owen's scrambling, different in each pixel. If spp is a power of two these are
/// (0, m, 3)-nets: one point in every box of volume 1 / spp that powers of two cut from pixel and shutter.
/// Every point by itself is uniform in x, y and its stratum, so estimates are unbiased.
///
/// Scrambling is a hash of the point's digits in reversed order (burley2020), here of 16 digits for each of x
/// and y side by side in 32 bits: positions are odd multiples of 2^-17 pixel. After 65536 points the digits
/// begin anew under another scrambling.
class StratifiedPattern {
 public:
  StratifiedPattern(uint64_t seed, int64_t frame, int spp);

  int spp() const { return spp_; }
  /// The keys of pixel (x, y), absolute, for the strata that share `stratum` / 65536.
  SampleKeys Keys(int x, int y, int stratum) const;
  /// Both digit strings of a stratum, not yet scrambled, lowest digit first.
  static uint32_t Digits(int stratum);

  /// Point `stratum` of a pixel, as the vector code makes it but for the rounding of t.
  StratifiedPoint At(int x, int y, int stratum) const;

 private:
  uint64_t frame_key_;
  int spp_;
};

/// Multipliers of the scrambling, the same for both halves.
inline constexpr uint32_t kScrambleFirst = 0xadea'adeau, kScrambleSecond = 0x6c56'6c56u,
                          kScrambleThird = 0x2864'2864u;
inline constexpr uint32_t kTimeMultiplier = 0x9e37'79b1u, kTimeMixer = 0x85eb'ca6bu;

/// The 16 lower bits in reversed order.
inline uint32_t Reverse16(uint32_t v) {
  v = v >> 8 | (v & 0xff) << 8;
  v = (v >> 4 & 0x0f0f) | (v & 0x0f0f) << 4;
  v = (v >> 2 & 0x3333) | (v & 0x3333) << 2;
  return (v >> 1 & 0x5555) | (v & 0x5555) << 1;
}

/// Owen's scrambling of 16 reversed digits. Sums, products with odd numbers and v ^ v * even carry only from
/// lower to higher digits, and the lowest is the first here.
inline uint32_t Scramble(uint32_t v, uint32_t a, uint32_t b, uint32_t c) {
  const auto times = [](uint32_t p, uint32_t q) { return p * q & 0xffff; };
  v ^= times(v, kScrambleFirst & 0xffff);
  v = (v + a) & 0xffff;
  v = times(v, b | 1);
  v ^= times(v, kScrambleSecond & 0xffff);
  v ^= times(v, c & 0xfffe);
  v = (v + c) & 0xffff;
  return v ^ times(v, kScrambleThird & 0xffff);
}

/// Both halves of a lane: scrambled, and in the order of a binary fraction again.
inline uint32_t ScrambleHalves(uint32_t digits, uint32_t a, uint32_t b, uint32_t c) {
  const uint32_t low = Scramble(digits & 0xffff, a & 0xffff, b & 0xffff, c & 0xffff);
  return Reverse16(Scramble(digits >> 16, a >> 16, b >> 16, c >> 16)) << 16 | Reverse16(low);
}

}  // namespace shutterline::engine
