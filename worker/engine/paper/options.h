#pragma once

namespace shutterline::engine::paper {

/// How finely the patch engine approximates. All that it does beyond these is exact up to rounding.
struct Options {
  /// n: into how many equal spans the shutter is cut for binning [gribel2011, section 5].
  int time_cells = 4;
  /// Outlines are refined until the middle of each piece lies this close to the true curve, pixels. At the
  /// default the right triangle is seen at 99.9 % of all (line, position, time) of every generated scene; at
  /// 0.1 px at 99.5 % of `debris`, in half of the time. See docs/math/patches.md, section 7.
  double outline_tolerance = 0.015;
  /// The same for depth, as a fraction of it: along outlines, and for the planes that are fitted in cells.
  double depth_tolerance = 1.0 / 1024;
  /// Cuts of one piece of outline: 2^refinements points at most.
  int refinements = 12;
  /// Halvings of a polygon within a cell where one plane does not follow its depth.
  int plane_halvings = 4;
};

}  // namespace shutterline::engine::paper
