#pragma once

#include <absl/container/flat_hash_map.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <tuple>
#include <vector>

#include "common/job/tile.h"

namespace shutterline::engine {

/// What one pixel sees of one triangle (within one shading bin of the shutter): the weight of the
/// pieces of lines and the mean position on the triangle, if it was asked for.
struct PixelPair {
  uint32_t triangle = 0;  ///< Index into FrameScene::triangles.
  uint16_t bin = 0;       ///< Shading bin: number `bin` of 2^bins_log2 equal spans of the shutter.
  uint16_t bins_log2 = 0;
  uint64_t weight = 0;    ///< Of PairWeights::total(): an exact integer.
  double b1 = 0, b2 = 0;  ///< Σ weight × barycentric coordinate; divide by weight.
  uint32_t next = 0;      ///< The pixel's next pair, 0: none. Internal.

  /// The middle of its part of the shutter.
  double MiddleTime() const { return (bin + 0.5) / double(1u << bins_log2); }
};

/// Weights of (triangle, pixel) pairs over a tile.
///
/// Weights are integers: subpixels along the line times the instant's weight. They are exact, so their
/// sum does not depend on any order, and the sum over a pixel's triangles and its background is exactly
/// total() [design: prefer counting to measuring].
class PairWeights {
 public:
  /// Empties, for a tile of `pixels` pixels whose every pixel has the weight `total`. `taps`: of the filter
  /// that spreads pairs over the pixels around theirs; 0 where there is none.
  void Reset(int64_t pixels, uint64_t total, int taps = 0);

  /// Adds a piece's weight to its pair; `piece.b1` and `piece.b2` are the barycentric coordinates of the
  /// piece's middle, not yet weighted (zeros where they are not wanted). `pixel` counts in rows within the
  /// tile. Returns the pair's number.
  uint32_t Add(int64_t pixel, const PixelPair& piece);

  /// Under a filter, what of total() the pixels around take of a pair: taps × taps of them in rows from the
  /// top, the pair's own in the middle. They add up to no more than total() in any pixel; pairs' own weights
  /// then say only how their positions were weighted.
  std::span<uint64_t> SpreadOf(uint32_t number) { return {spreads_.data() + number * spread_, spread_}; }
  std::span<const uint64_t> SpreadOf(uint32_t number) const {
    return {spreads_.data() + number * spread_, spread_};
  }
  const PixelPair& Pair(uint32_t number) const { return pairs_[number]; }
  /// Of a pair that ForEach shows: 1 to Count().
  uint32_t NumberOf(const PixelPair& pair) const { return uint32_t(&pair - pairs_.data()); }
  uint32_t Count() const { return uint32_t(pairs_.size() - 1); }

  uint64_t total() const { return total_; }

  /// Calls visit(const PixelPair&) for each pair of the pixel. The order is that of first arrival,
  /// latest first: sort by something that means something before adding floating-point numbers up.
  template <typename Visit>
  void ForEach(int64_t pixel, const Visit& visit) const {
    for (uint32_t i = first_[size_t(pixel)]; i != 0; i = pairs_[i].next) visit(pairs_[i]);
  }

 private:
  /// A pixel with more pairs than this has them in a hash table: hostile scenes put a million into one.
  static constexpr uint32_t kLongestSearch = 32;

  /// The pair that `piece` belongs to, 0 if there is none yet.
  uint32_t Find(int64_t pixel, const PixelPair& piece) const;
  uint32_t Append(int64_t pixel, const PixelPair& piece);

  std::vector<uint32_t> first_;   // By pixel: index into pairs_, 0: none.
  std::vector<PixelPair> pairs_;  // Entry 0 is unused.
  std::vector<uint32_t> length_;  // By pixel: its number of pairs.
  absl::flat_hash_map<std::tuple<int64_t, uint32_t, uint16_t>, uint32_t> index_;  // Of long lists.
  std::vector<uint64_t> spreads_;                                                 // By pair, spread_ of each.
  size_t spread_ = 0;
  uint64_t total_ = 0;
};

}  // namespace shutterline::engine
