#include "worker/engine/visibility/time_samples.h"

#include <algorithm>
#include <cmath>

#include "common/base/check.h"

namespace shutterline::engine {

TimeSamples::TimeSamples(const RenderSettings& settings)
    : time_step_(settings.time_step),
      pinned_(settings.time_samples),
      weight_per_line_(settings.time_samples ? *settings.time_samples : int64_t{1} << kMaxLog2) {}

int64_t TimeSamples::InstantsFor(double motion_pixels) const {
  if (pinned_) return *pinned_;
  // Error falls with the number of instants and does not grow with motion once that exceeds a pixel
  // (docs/math/line_samples.md), hence a floor; below half a pixel of motion it falls with the motion.
  const double floor = std::min<double>(kFewest, 2 * kFewest * motion_pixels);
  const double wanted = std::max(motion_pixels, floor) / time_step_;
  int log2 = 0;
  while (log2 < kMaxLog2 && double(int64_t{1} << log2) < wanted) ++log2;
  SL_CHECK(double(int64_t{1} << log2) >= wanted);
  return int64_t{1} << log2;
}

}  // namespace shutterline::engine
