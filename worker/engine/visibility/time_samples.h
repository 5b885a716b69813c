#pragma once

#include <cstdint>
#include <optional>

#include "common/job/render_settings.h"

namespace shutterline::engine {

/// How many instants a line is resolved at, and the weight of each.
///
/// Where nothing moves: one. Otherwise a power of two that follows the motion, or exactly what the user
/// pinned. All weights are integers in units of 1/WeightPerLine() of the shutter, so the instants of
/// every line add up to the same total whatever their number, and sums over lines of different numbers
/// of instants stay exact.
class TimeSamples {
 public:
  explicit TimeSamples(const RenderSettings& settings);

  /// Instants for a line over which triangles move by at most `motion_pixels`, 0 to kMostMotionPixels. A
  /// power of two, or the pinned number.
  int64_t InstantsFor(double motion_pixels) const;

  /// The instants' weights add up to this on every line.
  int64_t WeightPerLine() const { return weight_per_line_; }
  int64_t WeightOf(int64_t instants) const { return weight_per_line_ / instants; }

  /// Instant i of n on a line with this offset: stratified over [0, 1].
  static double InstantAt(int64_t i, int64_t n, double offset) { return (double(i) + offset) / double(n); }

  /// Enough for the largest motion at the smallest time step, so nothing is ever cut: 2^22 instants.
  static constexpr int kMaxLog2 = 22;
  /// Blur of a few pixels still spans the whole shutter: fewer instants than this, at a time step of 1,
  /// show as steps.
  static constexpr int kFewest = 16;

 private:
  double time_step_;
  std::optional<int> pinned_;
  int64_t weight_per_line_;
};

}  // namespace shutterline::engine
