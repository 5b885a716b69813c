#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "worker/engine/paper/outline.h"

namespace shutterline::engine::paper {

/// One straight piece of a depth patch: between t0 and t1 the triangle covers the line from `left` to
/// `right`, both linear in time. Depth is linear along the line at
/// each instant and along the sides; the four corners are in general not on one plane.
struct Slab {
  double t0 = 0, t1 = 0;
  double left0 = 0, left1 = 0, right0 = 0, right1 = 0;
  double depth_left0 = 0, depth_left1 = 0, depth_right0 = 0, depth_right1 = 0;
};

/// Makes a moving triangle's depth patches on one line [gribel2011, section 4 and appendix A], as slabs.
///
/// The feature points' times cut the shutter into spans of one pattern of signs. Within a span one vertex
/// is alone on its side and the connections of its two edges are the patch's sides. Cut at every point of
/// either side, a patch falls into slabs; where the sides cross, the triangle turns its other face to the
/// eye and the slab is cut there (last image of figure 19). Points that are added to a side by such cuts
/// lie on it up to rounding, so slabs of neighbours still meet.
///
/// Keeps its memory between triangles; one object per thread.
class DepthPatch {
 public:
  void Begin(const SegmentLine& line, const Options& options);

  /// Replaces slabs() by those of `triangle`, ascending in time, never two at one instant.
  void Make(const TileTriangle& triangle, double far_depth);

  /// The same for a triangle that stands still between two instants, as a resolved span [l0, l1].
  static Slab Static(double l0, double l1, double d0, double d1) {
    return {0, 1, l0, l0, l1, l1, d0, d0, d1, d1};
  }

  std::span<const Slab> slabs() const { return slabs_; }

 private:
  /// A side of a patch over a span: a polyline, and where in it we are.
  struct Side {
    const OutlinePoint* next = nullptr;
    OutlinePoint At(double t);
  };

  void AppendPiece(const LinearMotion& motion, const TileTriangle& triangle, double far_depth);
  void MakeSpan(const MovingSection& section, const TileTriangle& triangle, double t0, double t1);
  bool TraceClipped(const MovingSection& section, int lone, double t0, double t1);
  void Join(const OutlinePoint* next_points, const OutlinePoint* prev_points, double t0, double t1,
            bool front_is_next_first);
  void AddBetween(const OutlinePoint* a, const OutlinePoint* b, bool a_first_is_front);
  void AddGuarded(const Slab& slab);

  SegmentLine line_;
  double low_ = 0, high_ = 0;  ///< Beyond these, pixels, slabs are cut: no line is there.
  Options options_;
  bool cull_back_ = false;
  Outlines outlines_;
  std::vector<double> times_, cuts_;
  std::vector<OutlinePoint> traced_[2];
  std::vector<Slab> slabs_;
};

}  // namespace shutterline::engine::paper
