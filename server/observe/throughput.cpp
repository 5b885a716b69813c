#include "server/observe/throughput.h"

namespace shutterline::server {

int64_t Throughput::Now() const {
  return clock_.Monotonic() / kStep;
}

void Throughput::OnTileStored(const TileStored& seen) {
  const int64_t now = Now();
  absl::MutexLock lock(&mutex_);
  Bucket& bucket = buckets_[size_t(now % kSteps)];
  if (bucket.number != now) bucket = {now, {}};
  ++bucket.step.tiles;
  bucket.step.render_seconds += absl::ToDoubleSeconds(seen.render_time);
}

Throughput::Step Throughput::At(int64_t number) const {
  if (number < 0) return {};
  const Bucket& bucket = buckets_[size_t(number % kSteps)];
  return bucket.number == number ? bucket.step : Step();
}

std::vector<Throughput::Step> Throughput::Steps() const {
  const int64_t now = Now();
  absl::MutexLock lock(&mutex_);
  std::vector<Step> steps;
  for (int64_t number = now - kSteps + 1; number <= now; ++number) steps.push_back(At(number));
  return steps;
}

double Throughput::TilesPerSecond() const {
  constexpr int64_t kMinute = 12;  // Steps.
  const int64_t now = Now();
  absl::MutexLock lock(&mutex_);
  int64_t tiles = 0;
  for (int64_t number = now - kMinute; number < now; ++number) tiles += At(number).tiles;
  return double(tiles) / 60;
}

}  // namespace shutterline::server
