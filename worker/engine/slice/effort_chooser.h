#pragma once

#include <cstdint>

#include "common/job/render_settings.h"
#include "worker/engine/render/stats.h"
#include "worker/engine/sampling/line_pattern.h"
#include "worker/engine/sampling/shutter_curve.h"
#include "worker/engine/slice/effort_pilot.h"
#include "worker/engine/slice/line_class.h"
#include "worker/engine/slice/tile_colors.h"
#include "worker/engine/slice/tile_strata.h"
#include "worker/engine/visibility/color_film.h"
#include "worker/engine/visibility/time_samples.h"

namespace shutterline::engine {

/// How finely a tile is sampled.
struct Effort {
  const LinePattern* pattern = nullptr;
  int64_t instants = 1;  ///< On every line.
};

/// Chooses a tile's effort: instants by the length of motion, or, where an error is aimed at, instants and
/// lines by what a pilot finds. See docs/math/effort.md.
class EffortChooser {
 public:
  explicit EffortChooser(const RenderSettings& settings);

  /// What a tile's choice needs of memory.
  struct Workspace {
    EffortPilot pilot;
    TileLines lines;
    TileColors colors;
  };

  /// The film, which may be null, is written over. Thread-safe; the workspace is the caller's.
  Effort Choose(TileStrata& strata, ColorFilm* film, const AlphaSource* alpha, Workspace& work,
                RenderStats& stats) const;

 private:
  Effort Measure(TileStrata& strata, ColorFilm& film, const AlphaSource* alpha, Workspace& work,
                 RenderStats& stats) const;
  const LinePattern& PatternFor(double space_difference, double samples) const;

  const LinePattern& pattern_;
  bool pattern_is_free_;
  double target_error_;  // 0: none.
  ShutterCurve shutter_;
  TimeSamples by_motion_;
  TimeSamples at_most_;
};

}  // namespace shutterline::engine
