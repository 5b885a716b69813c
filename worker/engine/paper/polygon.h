#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace shutterline::engine::paper {

/// A point of an lt-cell: u along the line and v in time, both from 0 to 1 over the cell.
struct CellPoint {
  double u = 0, v = 0;
};

/// A convex polygon, counter-clockwise, as a range of an arena's points.
struct Polygon {
  uint32_t first = 0, count = 0;
};

/// u·du + v·dv + c; positive is inside.
struct HalfPlane {
  double du = 0, dv = 0, c = 0;
  double At(const CellPoint& p) const { return du * p.u + dv * p.v + c; }
};

struct PolygonSplit {
  Polygon positive, negative;  ///< Empty (count 0) where nothing is left.
  bool all_on = false;         ///< Every corner lies on the line; both are empty.
};

/// Area and, times area, the centre.
struct PolygonMoments {
  double area = 0, u = 0, v = 0;
};

/// The memory of polygons, used as a stack: take Mark() before work whose polygons are not wanted later and
/// give it to Release() afterwards, and nothing is allocated in the long run.
class PolygonArena {
 public:
  void Clear() { points_.clear(); }
  size_t Mark() const { return points_.size(); }
  void Release(size_t mark) { points_.resize(mark); }

  /// Add: points of a new polygon go one after the other.
  uint32_t Begin() const { return uint32_t(points_.size()); }
  void Append(const CellPoint& p) { points_.push_back(p); }
  Polygon End(uint32_t begin) const { return {begin, uint32_t(points_.size()) - begin}; }

  const CellPoint& At(const Polygon& polygon, uint32_t i) const { return points_[polygon.first + i]; }

  /// Cuts a polygon by a line. Corners whose value is within `tolerance` lie on it and go to both sides. A
  /// side that gets all of the polygon gets it as it is; new corners are computed once for both sides.
  PolygonSplit Split(const Polygon& polygon, const HalfPlane& line, double tolerance);

  PolygonMoments MomentsOf(const Polygon& polygon) const;

 private:
  std::vector<CellPoint> points_;
  std::vector<double> values_;
};

}  // namespace shutterline::engine::paper
