#pragma once

#include <cstdint>

/// Every epsilon and resolution of the engine, with its unit, its reason and the test that guards it.
/// There is no other: what is not here is compared exactly.
namespace shutterline {

/// Positions along a line sample are integers of 2^-24 pixel. Two triangles that share an edge compute
/// its crossing from the same numbers, hence round it to the same integer, and lengths of spans add up
/// without any rounding: coverage of a pixel sums to exactly one. 2^-24 px is far below what a picture
/// can show, and a line of 64 pixels still fits 32 bits. Guarded by `Row21ClosedMeshCoversExactly`.
inline constexpr int kSubpixelBits = 24;
inline constexpr int32_t kSubpixelsPerPixel = int32_t{1} << kSubpixelBits;

/// The longest side of a rectangle that the line integrator resolves at once, pixels: its lines' ends
/// must fit a signed 32-bit subpixel position. Larger rectangles are cut. Guarded by
/// `TilePartitionDoesNotMatter`.
inline constexpr int kMaxLinePixelsLog2 = 6;
inline constexpr int kMaxLinePixels = 1 << kMaxLinePixelsLog2;

/// A triangle's nearest depth is enlarged by this factor before it is compared with what lies in front:
/// both have been rounded a few times (2^-53 each), and a wrong cull would be seen while a missed one
/// costs nothing. Guarded by `Row35StackedLayers` and `Row19CoplanarDuplicates`.
inline constexpr double kDepthSlack = 1 + 1e-12;

/// The same where depths are single precision: they have been rounded a few times by 2^-24. Guarded by
/// `Row35StackedLayers`.
inline constexpr float kFloatDepthSlack = 1 + 1e-5f;

/// Line numbers are ranges of integers computed from raster positions in double precision; each end is
/// widened by this fraction of the spacing so that rounding never loses a line. Superfluous lines are
/// rejected exactly by signs. Positions far out, whose own rounding is coarser, get that in addition. Guarded
/// by `LineRangesAreConservative`.
inline constexpr double kLineRangeSlack = 1e-6;

/// Motion along the shutter that no bound is known for, because the triangle crosses the near plane, is
/// taken as this many pixels when the number of instants is chosen. Not a bound on correctness: only on
/// how finely time is cut there.
inline constexpr double kNearCrossingMotionPixels = 64;

/// Motion is measured between positions cut to the tile and this many pixels around it: what a vertex does
/// farther out, as a corner of a floor that comes close to the camera, says nothing about the tile. It
/// bounds the number of instants too; see kMostMotionPixels. Guarded by `MotionFarOutsideCostsNothing`.
inline constexpr double kMotionGuardPixels = 1024;

/// The largest motion that a triangle can have by this measure, in pixels: the guarded tile's diagonal.
inline constexpr double kMostMotionPixels = 3000;

/// A surface that moves in depth can pass another without moving in the picture at all. When instants are
/// chosen, motion in depth counts as this many pixels at least. Guarded by `Row38WithoutPinnedInstants`.
inline constexpr double kDepthMotionPixels = 0.5;

/// A primitive's motion is represented by curves that stay this close to the true path at every time that
/// is checked: pixels, and depth as a fraction of the distance from the camera (orthographic: of the depth
/// range). A twentieth of a pixel moves a pixel's coverage by less than 8-bit pictures can show. Guarded by
/// `CurvesStayWithinTolerance`.
inline constexpr double kPathPixels = 0.05;
inline constexpr double kPathDepth = 1e-4;

/// Where a method takes motion as straight pieces, these stay this close to the curve, pixels. Guarded by
/// `LinearPiecesFollowTheCurve`.
inline constexpr double kChordPixels = 0.01;

/// Patch engine: outlines are cut this many pixels outside the line. Coordinates farther out would cost the
/// digits of those on it. Guarded by `FarOutlinesAreCut`.
inline constexpr double kOutlineGuardPixels = 256;

/// Patch engine: a vertex of a polygon this close to a cutting line lies on it, in units of a cell (a pixel,
/// a span of the shutter). Corners that polygons share are cut apart only up to rounding, some 2^-50.
/// Guarded by `SplitsShareTheirCut`.
inline constexpr double kOnLine = 0x1p-44;

/// Patch engine: depths are equal where they differ by no more than this fraction; the lower triangle then
/// wins. Guarded by `Row19CoplanarDuplicates`.
inline constexpr double kEqualDepth = 1e-12;

/// Patch engine: what polygons leave of a cell, as a fraction, below which it is rounding and not background.
/// A thousand times what a hundred cuts amount to, and a thousandth of what a picture can show. Guarded
/// by `Row21ClosedMeshCoversExactly`.
inline constexpr double kCellSliver = 0x1p-28;

}  // namespace shutterline
