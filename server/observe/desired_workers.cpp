#include "server/observe/desired_workers.h"

#include <algorithm>
#include <cmath>

namespace shutterline::server {

int64_t DesiredWorkers(const FarmTotals& totals, absl::Duration target) {
  if (totals.remaining_tiles <= 0) return 0;
  const double slots =
      totals.workers > 0 ? std::max(1.0, double(totals.slots) / double(totals.workers)) : 1.0;
  const double by_time = std::ceil(totals.remaining_seconds / (absl::ToDoubleSeconds(target) * slots));
  const double by_tiles = std::ceil(double(totals.remaining_tiles) / slots);
  return int64_t(std::max(1.0, std::min(by_time, by_tiles)));
}

}  // namespace shutterline::server
