#pragma once

#include <span>
#include <vector>

#include "worker/engine/paper/moving_section.h"
#include "worker/engine/paper/options.h"

namespace shutterline::engine::paper {

/// A point of a patch outline: shutter time, position along the line (pixels from the tile's corner),
/// depth.
struct OutlinePoint {
  double t = 0, l = 0, d = 0;
};

/// A connection [gribel2011, appendix A]: what a moving edge traces in (l, t) between two of its feature
/// points, refined into straight pieces. Points are in ascending time.
struct Connection {
  int edge = 0;  ///< Edge e joins vertices e and (e + 1) % 3.
  double t0 = 0, t1 = 0;
  size_t first = 0, count = 0;  ///< In Outlines::points.
};

/// The connections of one triangle's three moving edges on one line.
///
/// They are functions of their edge and the line alone, refinement included, so that the two triangles at
/// an edge get the same points to the last bit and no crack can open between their patches. Positions
/// are rounded to 2^-24 px like those of static segments, for the same reason.
///
/// Keeps its memory between triangles; one object per thread.
class Outlines {
 public:
  void Begin(const SegmentLine& line, const Options& options) {
    line_begin_ = double(line.begin) / kSubpixelsPerPixel;
    line_end_ = double(line.end) / kSubpixelsPerPixel;
    options_ = options;
  }

  /// Replaces the connections by those of `section`. With `clip`, what lies outside the near and far plane
  /// is left out.
  void Make(const MovingSection& section, bool clip);

  std::span<const Connection> connections() const { return connections_; }
  const OutlinePoint* PointsOf(const Connection& c) const { return &points_[c.first]; }

  /// The connection of an edge that covers [t0, t1], null where it has none.
  const Connection* Find(int edge, double t0, double t1) const;

  /// Appends a refined curve from `from` to `to` to `out`, `from` left out; point_at(t) gives its points.
  /// Splits in the middle in time while the true point there is farther than the tolerances from the
  /// chord. The outline is not refined where it stays outside one end of the line; depth is, as it reaches
  /// in.
  template <typename PointAt>
  void Refine(const OutlinePoint& from, const OutlinePoint& to, const PointAt& point_at, int levels,
              std::vector<OutlinePoint>& out) const;

  /// Projects: l = g / w rounded to subpixels, d = z / w.
  static OutlinePoint Project(double t, const SectionPoint& p);

 private:
  void ConnectEdge(const MovingSection& section, int edge, bool clip);
  void AddConnection(const MovingSection& section, int edge, int above, int below, const OutlinePoint& from,
                     const OutlinePoint& to);
  void AddClipped(const MovingSection& section, int edge, int above, int below, const OutlinePoint& from,
                  const OutlinePoint& to, const SectionPoint& at_from, const SectionPoint& at_to);

  double line_begin_ = 0, line_end_ = 0;
  Options options_;
  std::vector<OutlinePoint> points_;
  std::vector<Connection> connections_;
};

template <typename PointAt>
void Outlines::Refine(const OutlinePoint& from, const OutlinePoint& to, const PointAt& point_at, int levels,
                      std::vector<OutlinePoint>& out) const {
  if (levels > 0) {
    const OutlinePoint middle = point_at(0.5 * (from.t + to.t));
    const double off_l = std::abs(middle.l - 0.5 * (from.l + to.l));
    const double off_d = std::abs(middle.d - 0.5 * (from.d + to.d));
    const bool before = from.l < line_begin_ && middle.l < line_begin_ && to.l < line_begin_;
    const bool behind = from.l > line_end_ && middle.l > line_end_ && to.l > line_end_;
    const bool coarse_l = off_l > options_.outline_tolerance && !before && !behind;
    if (coarse_l || off_d > options_.depth_tolerance * middle.d) {
      Refine(from, middle, point_at, levels - 1, out);
      Refine(middle, to, point_at, levels - 1, out);
      return;
    }
  }
  out.push_back(to);
}

}  // namespace shutterline::engine::paper
