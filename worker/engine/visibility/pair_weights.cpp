#include "worker/engine/visibility/pair_weights.h"

namespace shutterline::engine {

void PairWeights::Reset(int64_t pixels, uint64_t total, int taps) {
  first_.assign(size_t(pixels), 0);
  length_.assign(size_t(pixels), 0);
  pairs_.resize(1);
  index_.clear();
  spread_ = size_t(taps) * size_t(taps);
  spreads_.assign(spread_, 0);
  total_ = total;
}

uint32_t PairWeights::Find(int64_t pixel, const PixelPair& piece) const {
  if (length_[size_t(pixel)] > kLongestSearch) {
    const auto found = index_.find({pixel, piece.triangle, piece.bin});
    return found == index_.end() ? 0 : found->second;
  }
  // A pixel holds few pairs and the latest is mostly the next: a list searched from its newest end.
  uint32_t found = first_[size_t(pixel)];
  while (found != 0 && (pairs_[found].triangle != piece.triangle || pairs_[found].bin != piece.bin)) {
    found = pairs_[found].next;
  }
  return found;
}

uint32_t PairWeights::Append(int64_t pixel, const PixelPair& piece) {
  uint32_t& first = first_[size_t(pixel)];
  const auto added = uint32_t(pairs_.size());
  pairs_.push_back(
      {.triangle = piece.triangle, .bin = piece.bin, .bins_log2 = piece.bins_log2, .next = first});
  first = added;
  if (spread_ != 0) spreads_.resize(spreads_.size() + spread_);
  uint32_t& length = length_[size_t(pixel)];
  ++length;
  if (length == kLongestSearch + 1) {
    // From now on the pixel's pairs are looked up.
    for (uint32_t i = first; i != 0; i = pairs_[i].next)
      index_[{pixel, pairs_[i].triangle, pairs_[i].bin}] = i;
  } else if (length > kLongestSearch) {
    index_[{pixel, piece.triangle, piece.bin}] = added;
  }
  return added;
}

uint32_t PairWeights::Add(int64_t pixel, const PixelPair& piece) {
  uint32_t found = Find(pixel, piece);
  if (found == 0) found = Append(pixel, piece);
  PixelPair& pair = pairs_[found];
  pair.weight += piece.weight;
  pair.b1 += double(piece.weight) * piece.b1;
  pair.b2 += double(piece.weight) * piece.b2;
  return found;
}

}  // namespace shutterline::engine
