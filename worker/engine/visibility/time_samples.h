#pragma once

#include <cstdint>
#include <optional>

#include "common/job/render_settings.h"

namespace shutterline::engine {

/// How many instants a line is resolved at, and the weight of each.
///
/// Where nothing moves: one. Otherwise a power of two that follows the motion, or exactly what the user
/// pinned. All weights are integers in units of 1/WeightPerLine() of the shutter, so the instants of
/// every line add up to the same total whatever their number: sums over lines of different numbers of
/// instants stay exact, and a static line counts the same bits for any setting.
class TimeSamples {
 public:
  explicit TimeSamples(const RenderSettings& settings);

  /// Instants for a line over which triangles move by at most `motion_pixels`, > 0. A power of two, at
  /// most 2^kMaxLog2, or the pinned number. Sets `*clamped` where motion asked for more.
  int64_t InstantsFor(double motion_pixels, bool* clamped) const;

  /// The instants' weights add up to this on every line.
  int64_t WeightPerLine() const { return weight_per_line_; }
  int64_t WeightOf(int64_t instants) const { return weight_per_line_ / instants; }

  /// Instant i of n on a line with this offset: stratified over [0, 1].
  static double InstantAt(int64_t i, int64_t n, double offset) { return (double(i) + offset) / double(n); }

  static constexpr int kMaxLog2 = 20;
  /// Blur of a few pixels still spans the whole shutter: fewer instants than this show as steps.
  static constexpr int kFewest = 16;

 private:
  double time_step_;
  std::optional<int> pinned_;
  int64_t weight_per_line_;
};

}  // namespace shutterline::engine
