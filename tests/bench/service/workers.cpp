// Many connected workers: does one coordinator keep all of them busy?
#include <absl/strings/str_cat.h>
#include <absl/time/clock.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <map>
#include <thread>

#include "common/base/ids.h"
#include "common/job/tile.h"
#include "tests/bench/service/service_bench.h"
#include "tests/bench/service/simulated_worker.h"

namespace shutterline::bench {
namespace {

/// Runs tasks at their times, on one thread.
class Timer {
 public:
  Timer() : thread_([this] { Work(); }) {}
  ~Timer() {
    {
      absl::MutexLock lock(&mutex_);
      stopping_ = true;
    }
    thread_.join();
  }
  void Add(absl::Time time, std::function<void()> task) {
    absl::MutexLock lock(&mutex_);
    tasks_.emplace(time, std::move(task));
  }

 private:
  void Work() {
    absl::MutexLock lock(&mutex_);
    while (!stopping_) {
      while (!tasks_.empty() && tasks_.begin()->first <= absl::Now()) {
        const std::function<void()> task = std::move(tasks_.begin()->second);
        tasks_.erase(tasks_.begin());
        mutex_.Unlock();
        task();
        mutex_.Lock();
      }
      mutex_.AwaitWithTimeout(absl::Condition(&stopping_), absl::Milliseconds(1));
    }
  }

  absl::Mutex mutex_;
  std::multimap<absl::Time, std::function<void()>> tasks_ ABSL_GUARDED_BY(mutex_);
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  std::thread thread_;
};

/// A thousand connections need so many files, here and in the coordinator, which inherits the limit.
void RaiseFileLimit() {
  rlimit limit{};
  if (::getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
  limit.rlim_cur = limit.rlim_max;
  ::setrlimit(RLIMIT_NOFILE, &limit);
}

}  // namespace

bool MeasureWorkers(const ServiceOptions& options, const std::string& durability) {
  RaiseFileLimit();
  Farm farm;
  farm.server_flags = {"--durability", durability, "--log-level", "warn"};
  farm.StartServer();
  const double settle = std::min(5.0, options.seconds);
  const double rate = options.workers * 1000 / options.tile_ms;
  const std::string job = SubmitTiles(
      farm, int(rate * (options.seconds + settle) * 1.5) + options.workers * 10, options.tile_width);
  const std::string pixels(size_t(options.tile_width) * kTileSize * 4 * sizeof(float), '\0');
  std::vector<std::unique_ptr<SimulatedWorker>> workers;
  Timer timer;  // Ends before them.
  for (int i = 0; i < options.workers; ++i) {
    workers.push_back(std::make_unique<SimulatedWorker>(
        farm.Address(), MakeUuid(), &pixels, absl::Milliseconds(options.tile_ms),
        [&timer](absl::Time time, std::function<void()> task) { timer.Add(time, std::move(task)); }));
  }
  for (const auto& worker : workers) worker->Start();
  absl::SleepFor(absl::Seconds(settle));
  for (const auto& worker : workers) worker->BeginCount();
  const absl::Duration cpu = CpuOf(farm.server().pid()), own = CpuOf(::getpid());
  const absl::Time start = absl::Now();
  absl::SleepFor(absl::Seconds(options.seconds));
  const absl::Duration wall = absl::Now() - start;
  const absl::Duration spent = CpuOf(farm.server().pid()) - cpu, own_spent = CpuOf(::getpid()) - own;
  absl::Duration idle, worst;
  SimulatedWorker::Count sum;
  int broken = 0;
  for (const auto& worker : workers) {
    const SimulatedWorker::Count count = worker->EndCount();
    idle += count.idle;
    worst = std::max(worst, count.idle);
    sum.tiles += count.tiles;
    sum.batches += count.batches;
    sum.credits += count.credits;
    sum.grants += count.grants;
    broken += count.broken ? 1 : 0;
  }
  for (const auto& worker : workers) worker->Stop();
  const double tiles = std::max(1.0, double(sum.tiles));
  std::printf(
      "workers    durability=%-7s workers=%d tile_ms=%g tile_bytes=%zu tiles_per_second=%.0f of %.0f "
      "busy=%.2f%% least_busy=%.2f%% coordinator_cpu_ms_per_tile=%.4f coordinator_cores=%.2f "
      "simulation_cores=%.2f tiles_per_batch=%.1f grants_per_tile=%.2f credits_per_tile=%.2f broken=%d\n",
      durability.c_str(), options.workers, options.tile_ms, pixels.size(),
      double(sum.tiles) / absl::ToDoubleSeconds(wall), rate,
      100 - 100 * absl::FDivDuration(idle, wall * options.workers),
      100 - 100 * absl::FDivDuration(worst, wall), absl::ToDoubleMilliseconds(spent) / tiles,
      absl::FDivDuration(spent, wall), absl::FDivDuration(own_spent, wall),
      tiles / double(std::max<int64_t>(1, sum.batches)), double(sum.grants) / tiles,
      double(sum.credits) / tiles, broken);
  std::fflush(stdout);
  return broken == 0;
}

}  // namespace shutterline::bench
