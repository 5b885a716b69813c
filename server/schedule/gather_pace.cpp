#include "server/schedule/gather_pace.h"

#include <algorithm>

namespace shutterline::server {
namespace {

constexpr absl::Duration kCounted = absl::Seconds(1);  ///< Over which results are counted.
constexpr absl::Duration kRemembered = absl::Minutes(1);
constexpr double kLatest = 0.5;  ///< Weight of the latest count.

}  // namespace

void GatherPace::Tick(absl::Duration now, int64_t workers) {
  if (now - began_ < kCounted) return;
  const double seconds = absl::ToDoubleSeconds(now - began_);  // Infinite at first: nothing has been counted.
  rate_ += kLatest * (double(results_) / seconds - rate_);
  began_ = now;
  results_ = 0;
  const double needed = rate_ > options_.messages_per_second
                            ? double(workers) * (1 / options_.messages_per_second - 1 / rate_)
                            : 0;
  gather_ = std::clamp(absl::Seconds(needed), options_.least, options_.most);
  if (gather_ >= longest_ || now - longest_said_ > kRemembered) {
    longest_ = gather_;
    longest_said_ = now;
  }
}

}  // namespace shutterline::server
