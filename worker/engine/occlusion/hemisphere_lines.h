#pragma once

#include "common/job/occlusion_settings.h"

namespace shutterline::engine {

/// Cosine and sine.
struct Heading {
  double cosine = 1, sine = 0;
};

/// Of `turns` full turns, by additions and products alone, so that every processor gives the same bits.
Heading HeadingOf(double turns);

/// A line sample of the hemisphere [gribel2011, section 6.1]: the half of a great circle from -along by way
/// of `up` to along. In the local frame, whose z axis is the pole, along = (c, s, 0) and up = (-lean s, lean
/// c, √(1 - lean²)), where (c, s) is the heading.
struct HemisphereLine {
  Heading heading;
  double lean = 0;       ///< In (-1, 1): the height of the half ellipse that is the line on the disc.
  double instant = 0.5;  ///< Shutter time.
};

/// What one point adds to the pattern, each in [0, 1): the mean of the estimate over all of them is Eq. 1,
/// whatever the hemisphere sees.
struct LineShifts {
  double position = 0.5;  ///< Of the lines in their strata.
  double heading = 0;     ///< Of tilted lines, all together, in half turns.
  /// Of the instants, round the shutter: were they only to move in their strata, a place on the hemisphere
  /// would never be seen at some times.
  double instant = 0;
};

/// Line `i` of `settings.lines`. Every line has a stratum of its own of the shutter; lines that are
/// neighbours in space are far apart in time. Derived in docs/math/occlusion.md.
HemisphereLine LineAt(const OcclusionSettings& settings, int i, const LineShifts& shifts);

/// The shifts of a pixel: those of neighbouring pixels differ much, so that what is left of an error is fine
/// grain and not a pattern.
LineShifts ShiftsOfPixel(double raster_x, double raster_y);

}  // namespace shutterline::engine
