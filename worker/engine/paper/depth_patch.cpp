#include "worker/engine/paper/depth_patch.h"

#include <algorithm>
#include <cmath>

#include "common/math/tolerance.h"

namespace shutterline::engine::paper {
namespace {

double Mix(double a, double b, double s) {
  return a + s * (b - a);
}

/// The part of a slab between fractions s0 and s1 of its time. Depths are mixed along the sides.
Slab Part(const Slab& slab, double s0, double s1) {
  Slab part;
  part.t0 = s0 == 0 ? slab.t0 : Mix(slab.t0, slab.t1, s0);
  part.t1 = s1 == 1 ? slab.t1 : Mix(slab.t0, slab.t1, s1);
  const auto ends = [&](double a, double b, double& at0, double& at1) {
    at0 = s0 == 0 ? a : Mix(a, b, s0);
    at1 = s1 == 1 ? b : Mix(a, b, s1);
  };
  ends(slab.left0, slab.left1, part.left0, part.left1);
  ends(slab.right0, slab.right1, part.right0, part.right1);
  ends(slab.depth_left0, slab.depth_left1, part.depth_left0, part.depth_left1);
  ends(slab.depth_right0, slab.depth_right1, part.depth_right0, part.depth_right1);
  return part;
}

/// Cuts a segment of the line that reaches far beyond it, depth being linear along it.
void Guard(double low, double high, double& l, double& d, double other_l, double other_d) {
  const double cut = std::clamp(l, low, high);
  if (cut == l) return;
  const double s = (cut - l) / (other_l - l);
  d = std::isfinite(s) ? Mix(d, other_d, std::clamp(s, 0.0, 1.0)) : d;
  l = cut;
}

}  // namespace

void DepthPatch::Begin(const SegmentLine& line, const Options& options) {
  line_ = line;
  options_ = options;
  low_ = double(line.begin) / kSubpixelsPerPixel - kOutlineGuardPixels;
  high_ = double(line.end) / kSubpixelsPerPixel + kOutlineGuardPixels;
  outlines_.Begin(line, options);
}

void DepthPatch::Make(const TileTriangle& triangle, double far_depth) {
  slabs_.clear();
  cull_back_ = triangle.cull_back;
  // Curved motion is cut into straight pieces: as many for all of a mesh, so neighbours still agree.
  LinearMotion motion;
  triangle.VerticesAt(0, motion.close.data());
  for (int piece = 0; piece < triangle.linear_pieces; ++piece) {
    motion.open = motion.close;
    motion.t0 = double(piece) / triangle.linear_pieces;
    motion.t1 = double(piece + 1) / triangle.linear_pieces;
    triangle.VerticesAt(motion.t1, motion.close.data());
    AppendPiece(motion, triangle, far_depth);
  }
}

void DepthPatch::AppendPiece(const LinearMotion& motion, const TileTriangle& triangle, double far_depth) {
  const MovingSection section(motion, line_, far_depth);
  outlines_.Make(section, triangle.crosses_near);

  // Cut the motion at all feature points and at all ends of connections.
  times_.assign({motion.t0, motion.t1});
  for (int i = 0; i < 3; ++i) {
    if (section.PassageOf(i).passes) times_.push_back(section.PassageOf(i).t);
  }
  if (triangle.crosses_near) {
    for (const Connection& c : outlines_.connections()) times_.insert(times_.end(), {c.t0, c.t1});
  }
  std::sort(times_.begin(), times_.end());
  for (size_t i = 0; i + 1 < times_.size(); ++i) {
    if (times_[i] < times_[i + 1]) MakeSpan(section, triangle, times_[i], times_[i + 1]);
  }
}

void DepthPatch::MakeSpan(const MovingSection& section, const TileTriangle& triangle, double t0, double t1) {
  bool positive[3];
  for (int i = 0; i < 3; ++i) positive[i] = section.PassageOf(i).PositiveAfter(t0);
  if (positive[0] == positive[1] && positive[1] == positive[2]) return;
  const int lone = positive[1] == positive[2] ? 0 : positive[0] == positive[2] ? 1 : 2;

  // As in MakeSegment: the front shows where the order of the two edges on the line is this one.
  const bool front_is_next_first = positive[lone] != line_.major_is_x;
  const Connection* to_next = outlines_.Find(lone, t0, t1);
  const Connection* to_prev = outlines_.Find((lone + 2) % 3, t0, t1);
  if (to_next != nullptr && to_prev != nullptr) {
    Join(outlines_.PointsOf(*to_next), outlines_.PointsOf(*to_prev), t0, t1, front_is_next_first);
    return;
  }
  if (!triangle.crosses_near || !TraceClipped(section, lone, t0, t1)) return;
  Join(to_next != nullptr ? outlines_.PointsOf(*to_next) : traced_[0].data(),
       to_prev != nullptr ? outlines_.PointsOf(*to_prev) : traced_[1].data(), t0, t1, front_is_next_first);
}

/// Both sides of a span in which the near or the far plane cuts the triangle's segment. Only the triangle
/// itself has the cut, so it need not be shared. The segment is cut in homogeneous coordinates, before
/// anything is divided; the paper clips patch triangles instead.
bool DepthPatch::TraceClipped(const MovingSection& section, int lone, double t0, double t1) {
  const int next = (lone + 1) % 3;
  const int prev = (lone + 2) % 3;
  const bool lone_above = section.PassageOf(lone).PositiveAfter(t0);
  const auto cut = [](SectionPoint& p, SectionPoint& q, double at_p, double at_q) {
    const auto mix = [](const SectionPoint& a, double from_a, const SectionPoint& b, double from_b) {
      return SectionPoint{from_a * a.g + from_b * b.g, from_a * a.z + from_b * b.z,
                          from_a * a.w + from_b * b.w};
    };
    if (at_p < 0 && at_q < 0) return false;
    if (at_p < 0) {
      p = mix(p, at_q, q, -at_p);
    } else if (at_q < 0) {
      q = mix(q, at_p, p, -at_q);
    }
    return true;
  };
  const auto ends_at = [&](double t, SectionPoint(&ends)[2]) {
    ends[0] = lone_above ? section.Cross(lone, next, t) : section.Cross(next, lone, t);
    ends[1] = lone_above ? section.Cross(lone, prev, t) : section.Cross(prev, lone, t);
    if (!cut(ends[0], ends[1], MovingSection::InFrontOfNear(ends[0]),
             MovingSection::InFrontOfNear(ends[1]))) {
      return false;
    }
    for (SectionPoint& p : ends) p.w = std::max(p.w, p.z);
    return cut(ends[0], ends[1], section.InFrontOfFar(ends[0]), section.InFrontOfFar(ends[1])) &&
           ends[0].w > 0 && ends[1].w > 0;
  };

  // At its own ends a cut vanishes, and rounding says which way: look just inside.
  const double inset = 1e-9 * (t1 - t0);
  SectionPoint ends[2];
  SectionPoint first[2];
  SectionPoint last[2];
  if (!ends_at(0.5 * (t0 + t1), ends) || !ends_at(t0 + inset, first) || !ends_at(t1 - inset, last)) {
    return false;
  }
  for (const int side : {0, 1}) {
    const auto point_at = [&](double t) {
      return Outlines::Project(t, ends_at(t, ends) ? ends[side] : first[side]);
    };
    traced_[side].clear();
    traced_[side].push_back(Outlines::Project(t0, first[side]));
    const OutlinePoint end = Outlines::Project(t1, last[side]);
    outlines_.Refine(traced_[side].front(), end, point_at, options_.refinements, traced_[side]);
  }
  return true;
}

OutlinePoint DepthPatch::Side::At(double t) {
  while (next[1].t < t) ++next;
  if (next[0].t == t) return next[0];
  if (next[1].t == t) return next[1];
  const double s = (t - next[0].t) / (next[1].t - next[0].t);
  return {t, Mix(next[0].l, next[1].l, s), Mix(next[0].d, next[1].d, s)};
}

void DepthPatch::Join(const OutlinePoint* next_points, const OutlinePoint* prev_points, double t0, double t1,
                      bool front_is_next_first) {
  Side a{next_points};
  Side b{prev_points};
  OutlinePoint from[2] = {a.At(t0), b.At(t0)};
  while (from[0].t < t1) {
    // Go to the next point of either side.
    double t = t1;
    for (const Side* side : {&a, &b}) {
      const OutlinePoint* p = side->next;
      while (p->t <= from[0].t) ++p;
      t = std::min(t, p->t);
    }
    const OutlinePoint to[2] = {a.At(t), b.At(t)};
    const OutlinePoint side_a[2] = {from[0], to[0]};
    const OutlinePoint side_b[2] = {from[1], to[1]};
    AddBetween(side_a, side_b, front_is_next_first);
    from[0] = to[0];
    from[1] = to[1];
  }
}

/// The slab between a[0], a[1] and b[0], b[1], in two parts if these cross.
void DepthPatch::AddBetween(const OutlinePoint* a, const OutlinePoint* b, bool a_first_is_front) {
  const double gap0 = b[0].l - a[0].l;
  const double gap1 = b[1].l - a[1].l;
  if (!std::isfinite(gap0) || !std::isfinite(gap1)) return;
  if ((gap0 < 0 && gap1 > 0) || (gap0 > 0 && gap1 < 0)) {
    const double s = gap0 / (gap0 - gap1);
    const auto meet = [&](const OutlinePoint* side) {
      return OutlinePoint{Mix(side[0].t, side[1].t, s), Mix(side[0].l, side[1].l, s),
                          Mix(side[0].d, side[1].d, s)};
    };
    const OutlinePoint at_a = meet(a);
    OutlinePoint at_b = meet(b);
    at_b.l = at_a.l;  // One point.
    const OutlinePoint parts[4][2] = {{a[0], at_a}, {b[0], at_b}, {at_a, a[1]}, {at_b, b[1]}};
    AddBetween(parts[0], parts[1], a_first_is_front);
    AddBetween(parts[2], parts[3], a_first_is_front);
    return;
  }
  const bool a_first = gap0 + gap1 > 0;
  if (!(a[0].t < a[1].t) || !(std::abs(gap0 + gap1) > 0)) return;
  if (cull_back_ && a_first != a_first_is_front) return;
  const OutlinePoint* left = a_first ? a : b;
  const OutlinePoint* right = a_first ? b : a;
  AddGuarded({.t0 = a[0].t,
              .t1 = a[1].t,
              .left0 = left[0].l,
              .left1 = left[1].l,
              .right0 = right[0].l,
              .right1 = right[1].l,
              .depth_left0 = left[0].d,
              .depth_left1 = left[1].d,
              .depth_right0 = right[0].d,
              .depth_right1 = right[1].d});
}

/// Cuts away what lies so far from the line that its coordinates would spoil those on it.
void DepthPatch::AddGuarded(const Slab& slab) {
  const double ends[4] = {slab.left0, slab.left1, slab.right0, slab.right1};
  if (std::max(slab.right0, slab.right1) < low_ || std::min(slab.left0, slab.left1) > high_) return;
  if (std::all_of(ends, ends + 4, [&](double l) { return l >= low_ && l <= high_; })) {
    slabs_.push_back(slab);
    return;
  }
  // Cut in time where a side passes a border; then each side is on one side of it.
  cuts_.assign({0, 1});
  for (const double border : {low_, high_}) {
    for (const auto& [l0, l1] : {std::pair(slab.left0, slab.left1), std::pair(slab.right0, slab.right1)}) {
      if ((l0 < border) != (l1 < border)) cuts_.push_back(std::clamp((border - l0) / (l1 - l0), 0.0, 1.0));
    }
  }
  std::sort(cuts_.begin(), cuts_.end());
  for (size_t i = 0; i + 1 < cuts_.size(); ++i) {
    if (!(cuts_[i] < cuts_[i + 1])) continue;
    Slab part = Part(slab, cuts_[i], cuts_[i + 1]);
    const Slab whole = part;
    Guard(low_, high_, part.left0, part.depth_left0, whole.right0, whole.depth_right0);
    Guard(low_, high_, part.left1, part.depth_left1, whole.right1, whole.depth_right1);
    Guard(low_, high_, part.right0, part.depth_right0, whole.left0, whole.depth_left0);
    Guard(low_, high_, part.right1, part.depth_right1, whole.left1, whole.depth_left1);
    if (part.t0 < part.t1 && part.right0 - part.left0 + part.right1 - part.left1 > 0) slabs_.push_back(part);
  }
}

}  // namespace shutterline::engine::paper
