#include "worker/engine/slice/effort_chooser.h"

#include <algorithm>
#include <cmath>

namespace shutterline::engine {
namespace {

/// The picture's error at N samples a pixel is taken as kTimeShare · d · (N₀/N)^kTimeSlope, d being the
/// difference of the halves of a pilot of N₀ samples.
constexpr double kTimeShare = 0.2;
constexpr double kTimeSlope = 1.2;
/// The error of a pattern's lines is taken as kSpaceShare · d. That of `4h4v` is less than a third of that of
/// `rgls`.
constexpr double kSpaceShare = 0.25;
constexpr double kFinerLines = 3;

/// Between two of a pilot's instants things move by at most so many pixels, half a tile: what crosses a tile
/// is seen in it.
constexpr double kPilotStepPixels = 16;
constexpr int64_t kLeastPilot = 4;
constexpr int64_t kLeastInstants = 2;

RenderSettings WithTimeStep(RenderSettings settings, double time_step) {
  settings.time_step = time_step;
  return settings;
}

}  // namespace

EffortChooser::EffortChooser(const RenderSettings& settings)
    : pattern_(LinePattern::Get(settings.pattern)),
      pattern_is_free_(settings.pattern == PatternKind::kAuto),
      target_error_(settings.time_samples ? 0 : settings.target_error.value_or(0)),
      by_motion_(settings),
      at_most_(WithTimeStep(settings, std::min(settings.time_step, kFinestTimeStep))) {}

Effort EffortChooser::Choose(TileStrata& strata, ColorFilm* film, Workspace& work, RenderStats& stats) const {
  const bool can_measure = target_error_ > 0 && film != nullptr && film->CanGuess();
  if (strata.moves()) {
    if (can_measure) return ChooseMoving(strata, *film, work, stats);
    return {&pattern_, by_motion_.InstantsFor(strata.motion_pixels())};
  }
  if (can_measure && pattern_is_free_) return ChooseStill(strata, *film, work, stats);
  return {&pattern_, 1};
}

Effort EffortChooser::ChooseMoving(TileStrata& strata, ColorFilm& film, Workspace& work,
                                   RenderStats& stats) const {
  const double motion = strata.motion_pixels();
  const int64_t most = at_most_.InstantsFor(motion);
  const auto pilot_step = int64_t(std::ceil(motion / (2 * kPilotStepPixels * 4)));
  const int64_t pilot = std::max(kLeastPilot, 4 * pilot_step);
  if (pilot >= most) return {&pattern_, most};
  const EffortPilot::Findings found = work.pilot.OverTime(
      strata, work.lines.In(pattern_, strata.mesh().rect()), pilot, work.colors, film, stats);
  const double samples =
      double(found.samples) * std::pow(kTimeShare * found.difference / target_error_, 1 / kTimeSlope);
  int64_t instants = kLeastInstants;
  if (samples > 0) {
    instants = std::max(instants, int64_t(std::ceil(std::min(samples / pattern_.StepsPerPixel(), 1e9))));
  }
  // A texture that moves is blurred only as finely as time is cut.
  if (found.textured_motion_pixels > 0) {
    instants = std::max(instants, by_motion_.InstantsFor(found.textured_motion_pixels));
  }
  return {&pattern_, std::min(instants, most)};
}

Effort EffortChooser::ChooseStill(TileStrata& strata, ColorFilm& film, Workspace& work,
                                  RenderStats& stats) const {
  const EffortPilot::Findings found =
      work.pilot.OverSpace(strata, work.lines.In(pattern_, strata.mesh().rect()), work.colors, film, stats);
  if (kSpaceShare * found.difference <= target_error_) return {&pattern_, 1};
  const bool is_far = kSpaceShare * found.difference > kFinerLines * target_error_;
  return {&LinePattern::Get(is_far ? PatternKind::k8h8v : PatternKind::k4h4v), 1};
}

}  // namespace shutterline::engine
