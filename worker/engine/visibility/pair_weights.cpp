#include "worker/engine/visibility/pair_weights.h"

namespace shutterline::engine {

void PairWeights::Reset(int64_t pixels, uint64_t total) {
  first_.assign(size_t(pixels), 0);
  pairs_.resize(1);
  total_ = total;
}

void PairWeights::Add(int64_t pixel, const PixelPair& piece) {
  // A pixel holds few pairs and the latest is mostly the next: a list searched from its newest end.
  uint32_t& first = first_[size_t(pixel)];
  uint32_t found = first;
  while (found != 0 && (pairs_[found].triangle != piece.triangle || pairs_[found].bin != piece.bin)) {
    found = pairs_[found].next;
  }
  if (found == 0) {
    found = uint32_t(pairs_.size());
    pairs_.push_back(
        {.triangle = piece.triangle, .bin = piece.bin, .bins_log2 = piece.bins_log2, .next = first});
    first = found;
  }
  PixelPair& pair = pairs_[found];
  pair.weight += piece.weight;
  pair.b1 += double(piece.weight) * piece.b1;
  pair.b2 += double(piece.weight) * piece.b2;
}

}  // namespace shutterline::engine
