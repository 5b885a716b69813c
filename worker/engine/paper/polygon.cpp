#include "worker/engine/paper/polygon.h"

#include <algorithm>

namespace shutterline::engine::paper {

PolygonSplit PolygonArena::Split(const Polygon& polygon, const HalfPlane& line, double tolerance) {
  double low = 0;
  double high = 0;
  values_.resize(polygon.count);
  for (uint32_t i = 0; i < polygon.count; ++i) {
    values_[i] = line.At(points_[polygon.first + i]);
    low = std::min(low, values_[i]);
    high = std::max(high, values_[i]);
  }
  PolygonSplit split;
  if (low >= -tolerance) {
    if (high > tolerance) {
      split.positive = polygon;
    } else {
      split.all_on = true;
    }
    return split;
  }
  if (high <= tolerance) {
    split.negative = polygon;
    return split;
  }

  const auto cut = [&](bool positive) {
    const double sign = positive ? 1 : -1;
    const uint32_t begin = Begin();
    for (uint32_t i = 0; i < polygon.count; ++i) {
      const uint32_t j = i + 1 == polygon.count ? 0 : i + 1;
      const CellPoint p = points_[polygon.first + i];
      const double at_p = values_[i];
      const double at_q = values_[j];
      if (sign * at_p >= -tolerance) points_.push_back(p);
      if ((at_p > tolerance && at_q < -tolerance) || (at_p < -tolerance && at_q > tolerance)) {
        // The positive end first, so that the same edge of a neighbour is cut at the same bits.
        const CellPoint q = points_[polygon.first + j];
        const CellPoint& a = at_p > 0 ? p : q;
        const CellPoint& b = at_p > 0 ? q : p;
        const double s = std::max(at_p, at_q) / std::abs(at_p - at_q);
        points_.push_back({a.u + s * (b.u - a.u), a.v + s * (b.v - a.v)});
      }
    }
    return End(begin);
  };
  split.positive = cut(true);
  split.negative = cut(false);
  return split;
}

PolygonMoments PolygonArena::MomentsOf(const Polygon& polygon) const {
  PolygonMoments m;
  const CellPoint o = points_[polygon.first];
  for (uint32_t i = 1; i + 1 < polygon.count; ++i) {
    const CellPoint& p = points_[polygon.first + i];
    const CellPoint& q = points_[polygon.first + i + 1];
    const double area = 0.5 * ((p.u - o.u) * (q.v - o.v) - (p.v - o.v) * (q.u - o.u));
    m.area += area;
    m.u += area * ((p.u - o.u) + (q.u - o.u)) / 3;
    m.v += area * ((p.v - o.v) + (q.v - o.v)) / 3;
  }
  m.u += m.area * o.u;
  m.v += m.area * o.v;
  return m;
}

}  // namespace shutterline::engine::paper
