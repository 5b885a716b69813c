#include "worker/engine/slice/effort_chooser.h"

#include <algorithm>
#include <cmath>

namespace shutterline::engine {
namespace {

/// The picture's error at N samples a pixel is taken as kTimeShare · d · (N₀/N)^kTimeSlope, d being the
/// difference of the halves of a pilot of N₀ samples.
constexpr double kTimeShare = 0.25;
constexpr double kTimeSlope = 1.2;
/// The same where textures move: neighbouring texels have little to do with one another.
constexpr double kTextureShare = 0.2;
constexpr double kTextureSlope = 0.8;
/// What lines in space alone leave is taken as kSpaceShare · d with one horizontal and one vertical line a
/// pixel, d being the difference of the two, and as kFinerShare of that with twice as many.
constexpr double kSpaceShare = 0.2;
constexpr double kFinerShare = 0.36;
/// Patterns of even lines, and how many samples a pixel, split over lines and instants, are well spent on
/// each: with more, the lines that lie between are worth more than the instants that do.
struct EvenPattern {
  PatternKind kind;
  double most_samples;
};
constexpr EvenPattern kEvenPatterns[] = {{PatternKind::k1h1v, 40},
                                         {PatternKind::k2h2v, 128},
                                         {PatternKind::k4h4v, 512},
                                         {PatternKind::k8h8v, 1e18}};

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
      shutter_(settings.shutter_curve),
      by_motion_(settings),
      at_most_(WithTimeStep(settings, std::min(settings.time_step, kFinestTimeStep))) {}

Effort EffortChooser::Choose(TileStrata& strata, ColorFilm* film, const AlphaSource* alpha, Workspace& work,
                             RenderStats& stats) const {
  const bool can_measure = target_error_ > 0 && film != nullptr && film->CanGuess();
  if (can_measure && (strata.moves() || pattern_is_free_)) return Measure(strata, *film, alpha, work, stats);
  return {&pattern_, strata.moves() ? by_motion_.InstantsFor(strata.motion_pixels()) : 1};
}

Effort EffortChooser::Measure(TileStrata& strata, ColorFilm& film, const AlphaSource* alpha, Workspace& work,
                              RenderStats& stats) const {
  const double motion = strata.motion_pixels();
  const int64_t most = strata.moves() ? at_most_.InstantsFor(motion) : 1;
  const auto pilot_step = int64_t(std::ceil(motion / (2 * kPilotStepPixels * kLeastPilot)));
  const int64_t pilot = strata.moves() ? std::max(kLeastPilot, kLeastPilot * pilot_step) : 1;
  if (strata.moves() && pilot >= most) return {&pattern_, most};

  const LinePattern& single = LinePattern::Get(PatternKind::k1h1v);
  const EffortPilot::Findings found = work.pilot.Fly(strata, work.lines.In(single, strata.mesh().rect()),
                                                     pilot, shutter_, work.colors, film, alpha, stats);
  const double share = found.sees_moving_textures ? kTextureShare : kTimeShare;
  const double slope = found.sees_moving_textures ? kTextureSlope : kTimeSlope;
  const double samples =
      double(found.samples) * std::pow(share * found.time_difference / target_error_, 1 / slope);
  const LinePattern& pattern = pattern_is_free_ ? PatternFor(found.space_difference, samples) : pattern_;
  if (!strata.moves()) return {&pattern, 1};

  // Colours may be anything, and so may their differences.
  const double wanted = std::ceil(samples / pattern.StepsPerPixel());
  int64_t instants = wanted < double(most) ? int64_t(wanted) : most;
  instants = std::max(instants, kLeastInstants);
  // A texture that moves is blurred only as finely as time is cut.
  if (found.textured_motion_pixels > 0) {
    instants = std::max(instants, by_motion_.InstantsFor(found.textured_motion_pixels));
  }
  return {&pattern, std::min(instants, most)};
}

const LinePattern& EffortChooser::PatternFor(double space_difference, double samples) const {
  double error = kSpaceShare * space_difference;
  for (const EvenPattern& pattern : kEvenPatterns) {
    if (error <= target_error_ && samples <= pattern.most_samples) return LinePattern::Get(pattern.kind);
    error *= kFinerShare;
  }
  return LinePattern::Get(PatternKind::k8h8v);
}

}  // namespace shutterline::engine
