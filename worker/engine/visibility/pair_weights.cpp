#include "worker/engine/visibility/pair_weights.h"

namespace shutterline::engine {

void PairWeights::Reset(int64_t pixels, uint64_t total) {
  first_.assign(size_t(pixels), 0);
  pairs_.resize(1);
  total_ = total;
}

void PairWeights::Add(int64_t pixel, uint32_t triangle, uint32_t bin, uint64_t weight, double b1, double b2) {
  // A pixel holds few pairs and the latest is mostly the next: a list searched from its newest end.
  uint32_t& first = first_[size_t(pixel)];
  uint32_t found = first;
  while (found != 0 && (pairs_[found].triangle != triangle || pairs_[found].bin != bin)) found = pairs_[found].next;
  if (found == 0) {
    found = uint32_t(pairs_.size());
    pairs_.push_back({.triangle = triangle, .bin = bin, .next = first});
    first = found;
  }
  PixelPair& pair = pairs_[found];
  pair.weight += weight;
  pair.b1 += double(weight) * b1;
  pair.b2 += double(weight) * b2;
}

}  // namespace shutterline::engine
