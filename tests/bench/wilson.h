#pragma once

#include <cstdint>

namespace shutterline::bench {

struct Interval {
  double low = 0, high = 1;
};

/// Wilson's score interval of a proportion, `successes` of `trials`, at `z` standard deviations (1.96: 95 %).
/// Unlike the usual ± it stays within [0, 1] and says something when no trial failed. [0, 1] for no trials.
Interval WilsonInterval(int64_t successes, int64_t trials, double z = 1.959963984540054);

}  // namespace shutterline::bench
