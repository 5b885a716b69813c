#pragma once

#include <cstdint>
#include <vector>

#include "common/job/render_settings.h"
#include "common/job/tile.h"

namespace shutterline::engine {

/// Parallel line samples over the whole raster plane [gribel2011, section 7 and figure 9].
///
/// A family runs along its *major* axis: line k (any integer) is
///   minor = slope · major + offset + k · spacing,
/// with major = x, minor = y, or the other way round. Every step of one pixel along the major axis,
/// [i, i + 1], lies within exactly one pixel, and every pixel holds 1/spacing such steps, so a step's
/// weight within its pixel is the same for all steps of all families of a pattern.
/// All members are dyadic fractions: positions of lines are exact in double precision.
struct LineFamily {
  bool major_is_x = true;
  double slope = 0;    ///< Minor pixels per major pixel.
  double offset = 0;   ///< Pixels.
  double spacing = 1;  ///< Pixels between neighbours along the minor axis; a power of two, 1/16 to 1.
};

/// One line sample cut to a rectangle, in coordinates relative to the rectangle's top left corner.
struct TileLine {
  int family = 0;
  int64_t number = 0;    ///< k, absolute: the same line in every rectangle that it crosses.
  double intercept = 0;  ///< minor = slope · major + intercept, relative coordinates.
  /// The steps [i, i + 1] along the major axis, first_step <= i < end_step, lie within the rectangle.
  int first_step = 0, end_step = 0;
  /// Where in its stratum each of this line's instants lies, in (0, 1); see InstantOffset.
  double instant_offset = 0.5;
};

class LinePattern {
 public:
  /// `1h1v` to `16h16v`: horizontal and vertical lines through the pixels, evenly spaced.
  /// `rgls`: y = x/2 + k/2 and x = −y/2 + k/2; four lines through every pixel. Of `auto` too,
  /// as far as it has one.
  static const LinePattern& Get(PatternKind kind);

  const std::vector<LineFamily>& families() const { return families_; }
  /// Steps, over all families, that lie within one pixel: each has weight 1/StepsPerPixel().
  int StepsPerPixel() const { return steps_per_pixel_; }

  /// The lines that have a step within `rect`, family by family in ascending number. Positions and
  /// numbers depend on absolute raster coordinates only, so rectangles agree at their borders.
  std::vector<TileLine> LinesIn(const TileRect& rect) const;

  /// The pixel of step `step` of `line` within its rectangle, along the minor axis.
  int MinorPixel(const TileLine& line, int step) const;

 private:
  explicit LinePattern(std::vector<LineFamily> families);

  std::vector<LineFamily> families_;
  int steps_per_pixel_ = 0;
};

/// The offset of a line's instants within their strata of the shutter, in (0, 1): the van der Corput
/// sequence over the n lines that meet in a pixel, in the centres of its n cells. Those lines interleave
/// their instants evenly, so that n lines of K instants sample a pixel at nK equidistant times, and the
/// mean of their offsets is exactly ½: what changes linearly in time is integrated without error.
/// (Offsets that also differ from pixel to pixel lose that: every pixel is then biased by up to 1/(2nK).)
double InstantOffset(const LineFamily& family, int family_index, int64_t number);

}  // namespace shutterline::engine
