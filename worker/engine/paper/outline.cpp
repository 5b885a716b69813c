#include "worker/engine/paper/outline.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/math/tolerance.h"

namespace shutterline::engine::paper {
namespace {

/// Where a continuous function changes from `inside` (>= 0) or to it, between times a and b.
template <typename Value>
double ChangeOfSign(const Value& value, double a, double b) {
  const bool inside_at_a = value(a) >= 0;
  for (int step = 0; step < 60; ++step) {
    const double middle = 0.5 * (a + b);
    ((value(middle) >= 0) == inside_at_a ? a : b) = middle;
  }
  return 0.5 * (a + b);
}

}  // namespace

OutlinePoint Outlines::Project(double t, const SectionPoint& p) {
  const double w = p.w > 0 ? p.w : p.z;  // Behind the eye only by rounding: on the near plane w = z.
  const double l = p.g / w;
  // Beyond this a double has no subpixels, and no line.
  constexpr double kRoundable = 1 << 20;
  const double rounded =
      std::abs(l) < kRoundable ? std::floor(l * kSubpixelsPerPixel + 0.5) / kSubpixelsPerPixel : l;
  return {t, rounded, p.z / w};
}

void Outlines::Make(const MovingSection& section, bool clip) {
  points_.clear();
  connections_.clear();
  for (int edge = 0; edge < 3; ++edge) ConnectEdge(section, edge, clip);
}

const Connection* Outlines::Find(int edge, double t0, double t1) const {
  for (const Connection& c : connections_) {
    if (c.edge == edge && c.t0 <= t0 && t1 <= c.t1) return &c;
  }
  return nullptr;
}

void Outlines::ConnectEdge(const MovingSection& section, int edge, bool clip) {
  const int a = edge;
  const int b = (edge + 1) % 3;
  const Passage& of_a = section.PassageOf(a);
  const Passage& of_b = section.PassageOf(b);

  // The feature points' times cut the motion into spans; the edge crosses the plane in those in which its
  // ends are on different sides [gribel2011, figure 19]. Four feature points need no case of their own.
  std::array<double, 4> times{section.t0(), of_a.passes ? of_a.t : section.t0(),
                              of_b.passes ? of_b.t : section.t0(), section.t1()};
  std::sort(times.begin(), times.end());
  for (size_t i = 0; i + 1 < times.size(); ++i) {
    const double t0 = times[i];
    const double t1 = times[i + 1];
    if (!(t0 < t1)) continue;
    const bool a_positive = of_a.PositiveAfter(t0);
    if (a_positive == of_b.PositiveAfter(t0)) continue;
    const int above = a_positive ? a : b;
    const int below = a_positive ? b : a;
    const auto end = [&](double t, double other) -> SectionPoint {
      const bool at_a = of_a.At(t);
      const bool at_b = of_b.At(t);
      if (at_a && at_b) return section.CrossInPlane(above, below, t, other);
      if (!at_a && !at_b) return section.Cross(above, below, t);
      const SectionVertex v = section.VertexAt(at_a ? a : b, t);
      return {v.g, v.z, v.w};
    };
    const SectionPoint from = end(t0, t1);
    const SectionPoint to = end(t1, t0);
    if (clip) {
      AddClipped(section, edge, above, below, Project(t0, from), Project(t1, to), from, to);
    } else {
      AddConnection(section, edge, above, below, Project(t0, from), Project(t1, to));
    }
  }
}

void Outlines::AddConnection(const MovingSection& section, int edge, int above, int below,
                             const OutlinePoint& from, const OutlinePoint& to) {
  Connection connection{.edge = edge, .t0 = from.t, .t1 = to.t, .first = points_.size()};
  points_.push_back(from);
  const auto point_at = [&](double t) { return Project(t, section.Cross(above, below, t)); };
  Refine(from, to, point_at, options_.refinements, points_);
  connection.count = points_.size() - connection.first;
  connections_.push_back(connection);
}

void Outlines::AddClipped(const MovingSection& section, int edge, int above, int below,
                          const OutlinePoint& from, const OutlinePoint& to, const SectionPoint& at_from,
                          const SectionPoint& at_to) {
  // Along a connection the distances to the planes are polynomials of twice the motion's degree: look for
  // changes of their signs between this many samples.
  constexpr int kSamples = 16;
  const auto inside = [&](const SectionPoint& p) {
    return std::min(MovingSection::InFrontOfNear(p), section.InFrontOfFar(p));
  };
  const auto inside_at = [&](double t) { return inside(section.Cross(above, below, t)); };
  double previous_t = from.t;
  bool was_inside = inside(at_from) >= 0;
  OutlinePoint start = from;
  for (int i = 1; i <= kSamples; ++i) {
    const double t = i == kSamples ? to.t : from.t + (to.t - from.t) * (double(i) / kSamples);
    const bool is_inside = (i == kSamples ? inside(at_to) : inside_at(t)) >= 0;
    if (is_inside != was_inside) {
      const double at = ChangeOfSign(inside_at, previous_t, t);
      const OutlinePoint cut = Project(at, section.Cross(above, below, at));
      if (was_inside && start.t < at) AddConnection(section, edge, above, below, start, cut);
      start = cut;
    }
    was_inside = is_inside;
    previous_t = t;
  }
  if (was_inside && start.t < to.t) AddConnection(section, edge, above, below, start, to);
}

}  // namespace shutterline::engine::paper
