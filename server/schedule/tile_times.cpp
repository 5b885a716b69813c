#include "server/schedule/tile_times.h"

#include <algorithm>

namespace shutterline::server {

void TileTimes::Add(double seconds) {
  seconds_[count_++ % kKept] = float(seconds);
}

std::optional<double> TileTimes::NinetyFifth() const {
  if (count_ < kLeast) return std::nullopt;
  const size_t kept = std::min(count_, kKept);
  std::array<float, kKept> sorted = seconds_;
  const size_t rank = (kept * 95 + 99) / 100 - 1;
  std::nth_element(sorted.begin(), sorted.begin() + ptrdiff_t(rank), sorted.begin() + ptrdiff_t(kept));
  return sorted[rank];
}

}  // namespace shutterline::server
