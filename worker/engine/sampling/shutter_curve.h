#pragma once

#include <vector>

#include "common/job/render_settings.h"

namespace shutterline::engine {

/// Times of the shutter, weighed by how far it is open. Where weights are counted in integers, as ours are,
/// times should weigh the same: so times are as dense as the shutter is open, by the inverse of the share of
/// light that has come in until then. Immutable.
class ShutterCurve {
 public:
  /// `points` as RenderSettings::shutter_curve, validated. Empty: open all the time.
  explicit ShutterCurve(const std::vector<ShutterPoint>& points);

  /// The time by which the share `u` in [0, 1) of the light has come in; stratified for stratified u. `u`
  /// itself where the shutter is open all the time.
  double TimeOf(double u) const { return pieces_.empty() ? u : Invert(u); }

 private:
  /// From a point to the next: the light until then, and openings at both ends.
  struct Piece {
    double begin, length;
    double light_before, light_after;
    double opening, change;
  };
  double Invert(double u) const;

  std::vector<Piece> pieces_;
};

}  // namespace shutterline::engine
