#include "worker/engine/occlusion/line_segments.h"

#include <algorithm>
#include <cmath>

#include "worker/engine/occlusion/line_envelope.h"

namespace shutterline::engine {
namespace {

/// A direction in the line's plane, of any length.
struct Direction {
  double along, up;
};

/// Where the direction of something that goes straight from `a` to `b`, not through the origin, passes the
/// line through the origin along `edge`: one of its two ends.
Direction Cut(const Direction& a, const Direction& b, const Direction& edge) {
  const double height_a = edge.along * a.up - edge.up * a.along;
  const double height_b = edge.along * b.up - edge.up * b.along;
  const double place_a = edge.along * a.along + edge.up * a.up;
  const double place_b = edge.along * b.along + edge.up * b.up;
  const double side = (place_a * height_b - place_b * height_a) * (height_b > height_a ? 1 : -1);
  return side < 0 ? Direction{-edge.along, -edge.up} : edge;
}

/// Cuts off what is under the line through the origin along `edge`, on its right. False where nothing is
/// left.
bool ClipAbove(const Direction& edge, Direction& a, Direction& b) {
  const bool a_above = edge.along * a.up - edge.up * a.along > 0;
  const bool b_above = edge.along * b.up - edge.up * b.along > 0;
  if (!a_above && !b_above) return false;
  if (!a_above) {
    a = Cut(a, b, edge);
  } else if (!b_above) {
    b = Cut(a, b, edge);
  }
  return true;
}

/// Cuts off what is farther than `radius`. False where nothing is left.
bool ClipToRadius(double radius, Direction& a, Direction& b) {
  const double rr = radius * radius;
  const double aa = a.along * a.along + a.up * a.up, bb = b.along * b.along + b.up * b.up;
  if (aa <= rr && bb <= rr) return true;
  const Direction d{b.along - a.along, b.up - a.up};
  const double dd = d.along * d.along + d.up * d.up;
  const double middle = -(a.along * d.along + a.up * d.up) / dd;  // The place nearest to the origin.
  const double cross = a.along * b.up - a.up * b.along;
  const double half = rr / dd - (cross / dd) * (cross / dd);
  if (!(half > 0)) return false;
  const double root = std::sqrt(half);
  const double begin = std::max(0.0, middle - root), end = std::min(1.0, middle + root);
  if (!(begin < end)) return false;
  const Direction from = a;
  if (aa > rr) a = {from.along + begin * d.along, from.up + begin * d.up};
  if (bb > rr) b = {from.along + end * d.along, from.up + end * d.up};
  return true;
}

int32_t PositionOf(const Direction& d) {
  return PositionFrom(d.along / std::sqrt(d.along * d.along + d.up * d.up) * kLineEnd + kRounder);
}

}  // namespace

void LineSegments::Begin(const LineQuery& query, OcclusionFalloff falloff) {
  query_ = &query;
  falloff_ = falloff;
  const double least = kHeightRoundings * query.size;
  least_ = least * least;
  only_covers_ = falloff == OcclusionFalloff::kNone && !std::isfinite(query.radius);
  cover_.Clear();
  segments_.clear();
}

void LineSegments::Add(const LineSection& section) {
  const LineQuery& query = *query_;
  Direction a{section.along0, section.up0}, b{section.along1, section.up1};

  // An end at the point itself has no direction: the section is seen edge-on.
  const double aa = a.along * a.along + a.up * a.up, bb = b.along * b.along + b.up * b.up;
  if (aa <= least_ * section.weight0 * section.weight0 || bb <= least_ * section.weight1 * section.weight1) {
    return;
  }

  // Keep what is near.
  DistanceSegment segment;
  if (!only_covers_) {
    a = {a.along / section.weight0, a.up / section.weight0};
    b = {b.along / section.weight1, b.up / section.weight1};
    const double cross = a.along * b.up - a.up * b.along;
    segment.inverse_along = (b.up - a.up) / cross;
    segment.inverse_up = (a.along - b.along) / cross;
    if (!ClipToRadius(query.radius, a, b)) return;
  }

  // Keep what is over the face and over the horizon.
  if (!ClipAbove({query.face_up, -query.face_along}, a, b)) return;
  if (!ClipAbove({1, 0}, a, b)) return;

  // Round to positions on the line.
  const int32_t position_a = PositionOf(a), position_b = PositionOf(b);
  segment.begin = std::min(position_a, position_b);
  segment.end = std::max(position_a, position_b);
  if (segment.begin == segment.end) return;
  if (falloff_ == OcclusionFalloff::kNone) {
    cover_.Add(segment.begin, segment.end);
  } else if (std::isfinite(segment.inverse_along) && std::isfinite(segment.inverse_up)) {
    segments_.push_back(segment);
  }
}

int64_t LineSegments::Occlusion(OcclusionPattern pattern) {
  if (falloff_ != OcclusionFalloff::kNone) {
    return OcclusionOfNearest(segments_, {pattern, falloff_, query_->radius});
  }
  int64_t sum = 0;
  for (const LineInterval& interval : cover_.intervals()) {
    sum += ShareBelow(pattern, interval.end) - ShareBelow(pattern, interval.begin);
  }
  return sum;
}

}  // namespace shutterline::engine
