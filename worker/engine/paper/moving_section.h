#pragma once

#include <array>

#include "worker/engine/visibility/segment.h"
#include "worker/engine/visibility/tile_triangles.h"

namespace shutterline::engine::paper {

/// A point on the line-sample plane up to a positive factor: position along the line, depth and w.
struct SectionPoint {
  double g = 0, z = 0, w = 0;
};

/// A vertex as the line-sample plane sees it: f is its height over the plane.
struct SectionVertex {
  double f = 0, g = 0, z = 0, w = 0;
};

/// Whether and when a vertex passes the line-sample plane: its feature point in time [gribel2011, section
/// 4]. Its height is linear in time, so there is at most one.
struct Passage {
  bool positive_before = false;  ///< f >= 0 is positive, everywhere.
  bool passes = false;
  double t = 0;  ///< Shutter time.

  /// The side on which the vertex is just after `time`.
  bool PositiveAfter(double time) const { return positive_before != (passes && t <= time); }
  bool At(double time) const { return passes && t == time; }
};

/// A triangle whose vertices move linearly over [t0, t1] of the shutter. Curved motion comes in several.
struct LinearMotion {
  double t0 = 0, t1 = 1;
  std::array<RasterPoint, 3> open, close;
};

/// A moving triangle relative to one line-sample plane. All that two triangles share at an edge or at a
/// vertex is computed from that edge or vertex alone, so both get the same bits.
class MovingSection {
 public:
  MovingSection(const LinearMotion& motion, const SegmentLine& line, double far_depth);

  double t0() const { return t0_; }
  double t1() const { return t1_; }

  SectionVertex VertexAt(int vertex, double t) const;
  const Passage& PassageOf(int vertex) const { return passages_[size_t(vertex)]; }

  /// Where edge (above, below) meets the plane at t, as the convex combination of its ends whose weights
  /// are the heights. The signs of the heights are known from the passages, so rounding cannot make a
  /// weight negative. Departs from [gribel2011, equations 2 and 3]: no difference is divided by.
  SectionPoint Cross(int above, int below, double t) const;

  /// The same at an instant at which both ends pass the plane: the limit from the side of `toward`.
  SectionPoint CrossInPlane(int above, int below, double t, double toward) const;

  /// Signed distances, up to positive factors, to the near and the far plane: negative is clipped.
  static double InFrontOfNear(const SectionPoint& p) { return p.w - p.z; }
  double InFrontOfFar(const SectionPoint& p) const { return p.z - far_depth_ * p.w; }

 private:
  double t0_, t1_, far_depth_;
  std::array<SectionVertex, 3> open_, close_;
  std::array<Passage, 3> passages_;
};

}  // namespace shutterline::engine::paper
