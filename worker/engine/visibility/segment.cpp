#include "worker/engine/visibility/segment.h"

#include <cmath>

namespace shutterline::engine {
namespace {

/// A point of the triangle on the line-sample plane, up to a positive factor: position along the line,
/// depth and barycentric coordinates, all homogeneous.
struct Crossing {
  double g, z, w;
  double b1, b2, sum;
};

/// weight_a * a + weight_b * b; both weights >= 0, not both 0.
Crossing Combine(double weight_a, const Crossing& a, double weight_b, const Crossing& b) {
  return {weight_a * a.g + weight_b * b.g,   weight_a * a.z + weight_b * b.z,
          weight_a * a.w + weight_b * b.w,   weight_a * a.b1 + weight_b * b.b1,
          weight_a * a.b2 + weight_b * b.b2, weight_a * a.sum + weight_b * b.sum};
}

/// Cuts the segment from `p` to `q` where `inside` (linear and homogeneous, >= 0 is inside) changes sign.
/// Returns false if nothing is left. The cut is a convex combination again.
template <typename Inside>
bool Clip(Crossing& p, Crossing& q, const Inside& inside) {
  const double at_p = inside(p);
  const double at_q = inside(q);
  if (at_p < 0 && at_q < 0) return false;
  if (at_p < 0) {
    p = Combine(at_q, p, -at_p, q);
  } else if (at_q < 0) {
    q = Combine(at_p, q, -at_q, p);
  }
  return true;
}

/// Pixels along the line to subpixels, cut to the line.
int32_t ToSubpixels(double l, const SegmentLine& line) {
  const double scaled = l * kSubpixelsPerPixel + 0.5;  // Truncation then rounds to nearest, as l >= 0.
  return int32_t(std::clamp(scaled, double(line.begin), double(line.end)));
}

}  // namespace

SegmentBarycentric BarycentricAt(const LineSegment& segment, const SegmentPosition& position, double l) {
  const double s = std::clamp((l - segment.l0) / (segment.l1 - segment.l0), 0.0, 1.0);
  const auto mix = [s](const double(&ends)[2]) { return (1 - s) * ends[0] + s * ends[1]; };
  const double over = mix(position.one_over_w);
  return {mix(position.b1_over_w) / over, mix(position.b2_over_w) / over};
}

SegmentLine MakeSegmentLine(const LinePattern& pattern, const TileLine& line) {
  const LineFamily& family = pattern.families()[line.family];
  return {.major_is_x = family.major_is_x,
          .slope = family.slope,
          .intercept = line.intercept,
          .begin = line.first_step * kSubpixelsPerPixel,
          .end = line.end_step * kSubpixelsPerPixel};
}

bool MakeSegment(const TileTriangle& triangle, uint32_t index, double far_depth, const SegmentLine& line,
                 double t, LineSegment* segment, SegmentPosition* position) {
  // Evaluate the heights over the line-sample plane.
  RasterPoint v[3];
  triangle.VerticesAt(t, v);
  double f[3];
  bool positive[3];
  for (int i = 0; i < 3; ++i) {
    const double major = line.major_is_x ? v[i].x : v[i].y;
    const double minor = line.major_is_x ? v[i].y : v[i].x;
    f[i] = minor - line.slope * major - line.intercept * v[i].w;
    positive[i] = f[i] >= 0;
  }
  if (positive[0] == positive[1] && positive[1] == positive[2]) return false;

  // Find the vertex that is alone on its side.
  const int lone = positive[1] == positive[2] ? 0 : positive[0] == positive[2] ? 1 : 2;
  const int next = (lone + 1) % 3;
  const int prev = (lone + 2) % 3;

  // Cross its two edges.
  const auto vertex = [&](int i) -> Crossing {
    return {line.major_is_x ? v[i].x : v[i].y, v[i].z, v[i].w, i == 1 ? 1.0 : 0.0, i == 2 ? 1.0 : 0.0, 1.0};
  };
  const auto cross = [&](int other) {
    const int above = positive[lone] ? lone : other;
    const int below = positive[lone] ? other : lone;
    return Combine(-f[below], vertex(above), f[above], vertex(below));
  };
  Crossing from_next = cross(next);
  Crossing from_prev = cross(prev);

  // Clip at the near and the far plane, in homogeneous coordinates.
  if (triangle.crosses_near) {
    if (!Clip(from_next, from_prev, [](const Crossing& c) { return c.w - c.z; })) return false;
    // On the near plane w = z: said so, because w may have cancelled where z has not.
    for (Crossing* c : {&from_next, &from_prev}) c->w = std::max(c->w, c->z);
    if (!Clip(from_next, from_prev, [&](const Crossing& c) { return c.z - far_depth * c.w; })) return false;
    if (from_next.w <= 0 || from_prev.w <= 0) return false;
  }

  // Project, and see which way the triangle faces from the order of its two edges on the line.
  const double l_next = from_next.g / from_next.w;
  const double l_prev = from_prev.g / from_prev.w;
  if (!(l_next < l_prev || l_next > l_prev)) return false;
  const bool next_first = l_next < l_prev;
  if (triangle.cull_back && (next_first == (positive[lone] == line.major_is_x))) return false;
  const Crossing& first = next_first ? from_next : from_prev;
  const Crossing& second = next_first ? from_prev : from_next;
  segment->l0 = next_first ? l_next : l_prev;
  segment->l1 = next_first ? l_prev : l_next;

  // Round the ends to subpixels, within the line.
  segment->begin = ToSubpixels(segment->l0, line);
  segment->end = ToSubpixels(segment->l1, line);
  if (segment->begin >= segment->end) return false;
  segment->id = triangle.id;
  segment->index = index;
  segment->d0 = first.z / first.w;
  segment->d1 = second.z / second.w;
  segment->slope = (segment->d1 - segment->d0) / (segment->l1 - segment->l0);

  if (position != nullptr) {
    const Crossing* ends[2] = {&first, &second};
    for (int e = 0; e < 2; ++e) {
      position->b1_over_w[e] = ends[e]->b1 / ends[e]->w;
      position->b2_over_w[e] = ends[e]->b2 / ends[e]->w;
      position->one_over_w[e] = ends[e]->sum / ends[e]->w;
    }
  }
  return true;
}

}  // namespace shutterline::engine
