#include "tests/bench/wilson.h"

#include <algorithm>
#include <cmath>

#include "common/base/check.h"

namespace shutterline::bench {

Interval WilsonInterval(int64_t successes, int64_t trials, double z) {
  SL_CHECK(successes >= 0 && successes <= trials);
  if (trials == 0) return {};
  const double n = double(trials), p = double(successes) / n, z2 = z * z;
  const double middle = (p + z2 / (2 * n)) / (1 + z2 / n);
  const double half = z / (1 + z2 / n) * std::sqrt(p * (1 - p) / n + z2 / (4 * n * n));
  // Where none or all succeeded, that end is exact; the formula has a rounding there.
  return {successes == 0 ? 0 : std::max(0.0, middle - half),
          successes == trials ? 1 : std::min(1.0, middle + half)};
}

}  // namespace shutterline::bench
