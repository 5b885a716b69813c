#include "worker/engine/paper/moving_section.h"

#include <cmath>

namespace shutterline::engine::paper {
namespace {

SectionVertex Project(const RasterPoint& p, const SegmentLine& line) {
  const double major = line.major_is_x ? p.x : p.y;
  const double minor = line.major_is_x ? p.y : p.x;
  return {minor - line.slope * major - line.intercept * p.w, major, p.z, p.w};
}

SectionPoint Combine(double from_a, const SectionVertex& a, double from_b, const SectionVertex& b) {
  return {from_a * a.g + from_b * b.g, from_a * a.z + from_b * b.z, from_a * a.w + from_b * b.w};
}

}  // namespace

MovingSection::MovingSection(const LinearMotion& motion, const SegmentLine& line, double far_depth)
    : t0_(motion.t0), t1_(motion.t1), far_depth_(far_depth) {
  for (size_t i = 0; i < 3; ++i) {
    open_[i] = Project(motion.open[i], line);
    close_[i] = Project(motion.close[i], line);
    const double a = open_[i].f;
    const double b = close_[i].f;
    Passage& passage = passages_[i];
    passage.positive_before = a >= 0;
    passage.passes = passage.positive_before != (b >= 0);
    if (passage.passes) passage.t = t0_ + (t1_ - t0_) * (a / (a - b));
  }
}

SectionVertex MovingSection::VertexAt(int vertex, double t) const {
  const SectionVertex& a = open_[size_t(vertex)];
  const SectionVertex& b = close_[size_t(vertex)];
  // A vertex at rest comes out bit for bit, whatever t.
  const double s = (t - t0_) / (t1_ - t0_);
  return {a.f + s * (b.f - a.f), a.g + s * (b.g - a.g), a.z + s * (b.z - a.z), a.w + s * (b.w - a.w)};
}

SectionPoint MovingSection::Cross(int above, int below, double t) const {
  const SectionVertex a = VertexAt(above, t);
  const SectionVertex b = VertexAt(below, t);
  return Combine(std::abs(b.f), a, std::abs(a.f), b);
}

SectionPoint MovingSection::CrossInPlane(int above, int below, double t, double toward) const {
  // Heights that vanish together keep their ratio, as both are linear.
  return Combine(std::abs(VertexAt(below, toward).f), VertexAt(above, t), std::abs(VertexAt(above, toward).f),
                 VertexAt(below, t));
}

}  // namespace shutterline::engine::paper
