#pragma once

#include <cstdint>

#include "common/job/occlusion_settings.h"

namespace shutterline::engine {

/// A piece of a line's plane that occludes, seen between two positions on the line. On a straight segment the
/// inverse of the distance is linear in the unit direction (l, h): 1/d = inverse_along l + inverse_up h.
struct DistanceSegment {
  int32_t begin = 0, end = 0;  ///< Positions on the line, see line_measure.h.
  double inverse_along = 0, inverse_up = 0;
};

/// A unit direction on a line.
struct LineDirection {
  double along = 0, up = 1;
};

/// What fall-off asks of a line.
struct FalloffRule {
  OcclusionPattern pattern;
  OcclusionFalloff falloff;  ///< Not kNone.
  double radius;             ///< Finite.
};

/// ∫ (1 - ρ(d)) over a visible piece of `segment` from direction `a` to direction `b`, as a share of the
/// line. The piece is cut into panels over which the distance changes by a factor of two and the direction by
/// 45° at most, each integrated by Gauss' rule of five points: exact to 1e-6. Same bits on every processor.
double OcclusionOfPiece(const DistanceSegment& segment, const LineDirection& a, const LineDirection& b,
                        const FalloffRule& rule);

}  // namespace shutterline::engine
