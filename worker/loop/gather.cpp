#include "worker/loop/gather.h"

#include <algorithm>

#include "common/base/check.h"

namespace shutterline::worker {

void Gather::SetPace(absl::Duration pace) {
  pace_ = std::clamp(pace, absl::ZeroDuration(), kLongest);
}

void Gather::Add(size_t bytes, absl::Duration now) {
  if (results_++ == 0) since_ = now;
  bytes_ += bytes;
}

void Gather::Remove(size_t bytes) {
  SL_CHECK(results_ > 0 && bytes <= bytes_);
  bytes_ -= bytes;
  // What did not fit into a message keeps its time, and is late for the next.
  if (--results_ == 0) hurry_ = false;
}

absl::Duration Gather::Due(size_t enough_bytes) const {
  if (results_ == 0) return absl::InfiniteDuration();
  if (hurry_ || results_ >= kEnoughResults || bytes_ >= enough_bytes) return -absl::InfiniteDuration();
  return since_ + pace_;
}

}  // namespace shutterline::worker
