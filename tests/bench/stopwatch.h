#pragma once

#include <time.h>

namespace shutterline::bench {

/// Wall time, and user and system time of all the process's threads, since it was made.
class Stopwatch {
 public:
  double Wall() const { return Now(CLOCK_MONOTONIC) - wall_; }
  double Cpu() const { return Now(CLOCK_PROCESS_CPUTIME_ID) - cpu_; }

 private:
  static double Now(clockid_t clock) {
    timespec time{};
    clock_gettime(clock, &time);
    return double(time.tv_sec) + 1e-9 * double(time.tv_nsec);
  }

  double wall_ = Now(CLOCK_MONOTONIC), cpu_ = Now(CLOCK_PROCESS_CPUTIME_ID);
};

}  // namespace shutterline::bench
