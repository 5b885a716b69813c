#include "worker/engine/visibility/envelope.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace shutterline::engine {
namespace {

constexpr double kPixelsPerSubpixel = 1.0 / kSubpixelsPerPixel;
constexpr uint32_t kNone = std::numeric_limits<uint32_t>::max();

/// Appends [begin, end), joining it with the last span if that shows the same segment up to `begin`.
void Emit(std::vector<VisibleSpan>& spans, int32_t begin, int32_t end, uint32_t segment) {
  if (begin >= end) return;
  if (!spans.empty() && spans.back().segment == segment && spans.back().end == begin) {
    spans.back().end = end;
  } else {
    spans.push_back({begin, end, segment});
  }
}

}  // namespace

bool IsNearer(const LineSegment& a, const LineSegment& b, int32_t x) {
  const double l = (x + 0.5) * kPixelsPerSubpixel;
  const double depth_a = a.DepthAt(l);
  const double depth_b = b.DepthAt(l);
  if (depth_a != depth_b) return depth_a > depth_b;
  if (a.slope != b.slope) return a.slope > b.slope;
  return a.id < b.id;
}

int32_t EnvelopeMarcher::OvertakesAt(const LineSegment& a, const LineSegment& b, int32_t x, int32_t stop) {
  if (!(b.slope > a.slope)) return stop;
  // The place is computed from the pair alone, so it does not depend on how the march came here.
  const int32_t from = std::max(a.begin, b.begin);
  const double l = from * kPixelsPerSubpixel;
  const double lead = (a.d0 + a.slope * (l - a.l0)) - (b.d0 + b.slope * (l - b.l0));
  const double at = (l + lead / (b.slope - a.slope)) * kSubpixelsPerPixel;
  if (!(at < stop)) return stop;
  return std::max(x + 1, at > x ? int32_t(std::ceil(at)) : x + 1);
}

bool EnvelopeMarcher::SoonerChange(std::span<const LineSegment> segments, const Change& a, const Change& b) {
  if (b.to == kNone) return true;
  if (a.at != b.at) return a.at < b.at;
  // Both overtake within one subpixel: the one that is nearer there goes on.
  return IsNearer(segments[a.to], segments[b.to], a.at);
}

EnvelopeMarcher::Change EnvelopeMarcher::NextOvertake(std::span<const LineSegment> segments, uint32_t current,
                                                      int32_t x) {
  Change next{std::numeric_limits<int32_t>::max(), kNone};
  for (size_t i = 0; i < active_.size();) {
    const uint32_t candidate = active_[i];
    if (segments[candidate].end <= x) {  // Ended: forget it.
      active_[i] = active_.back();
      active_.pop_back();
      continue;
    }
    ++i;
    if (candidate == current) continue;
    const int32_t stop = std::min(segments[current].end, segments[candidate].end);
    const int32_t at = OvertakesAt(segments[current], segments[candidate], x, stop);
    const Change change{at, candidate};
    if (at < stop && SoonerChange(segments, change, next)) next = change;
  }
  return next;
}

uint32_t EnvelopeMarcher::NearestActive(std::span<const LineSegment> segments, int32_t x) const {
  uint32_t nearest = kNone;
  for (const uint32_t candidate : active_) {
    if (segments[candidate].end <= x) continue;
    if (nearest == kNone || IsNearer(segments[candidate], segments[nearest], x)) nearest = candidate;
  }
  return nearest;
}

void EnvelopeMarcher::March(std::span<const LineSegment> segments, int32_t begin, int32_t end,
                            std::vector<VisibleSpan>& spans) {
  spans.clear();
  active_.clear();
  by_start_.resize(segments.size());
  std::iota(by_start_.begin(), by_start_.end(), 0u);
  std::sort(by_start_.begin(), by_start_.end(),
            [&](uint32_t a, uint32_t b) { return segments[a].begin < segments[b].begin; });

  size_t next_start = 0;
  uint32_t current = kNone;
  Change overtake{0, kNone};
  int32_t x = begin;
  while (x < end) {
    // With nothing in front: admit what has started and take the nearest, or go on to the next start.
    if (current == kNone) {
      while (next_start < by_start_.size() && segments[by_start_[next_start]].begin <= x) {
        active_.push_back(by_start_[next_start++]);
      }
      current = NearestActive(segments, x);
      if (current == kNone) {
        active_.clear();
        if (next_start == by_start_.size()) break;
        x = segments[by_start_[next_start]].begin;
        continue;
      }
      overtake = NextOvertake(segments, current, x);
    }

    const int32_t stop = std::min(segments[current].end, end);
    const int32_t change_at = overtake.to == kNone ? stop : std::min(stop, overtake.at);

    // A segment starts before anything else happens: it hides the current one, or may overtake it later.
    if (next_start < by_start_.size() && segments[by_start_[next_start]].begin < change_at) {
      const uint32_t started = by_start_[next_start++];
      const int32_t at = std::max(segments[started].begin, x);
      if (segments[started].end <= at) continue;
      active_.push_back(started);
      if (IsNearer(segments[started], segments[current], at)) {
        Emit(spans, x, at, current);
        x = at;
        // The current one may have fallen behind others within this very subpixel.
        current = NearestActive(segments, x);
        overtake = NextOvertake(segments, current, x);
      } else {
        const int32_t both = std::min(segments[current].end, segments[started].end);
        const Change change{OvertakesAt(segments[current], segments[started], at, both), started};
        if (change.at < both && SoonerChange(segments, change, overtake)) overtake = change;
      }
      continue;
    }

    // The current segment is overtaken, or ends.
    Emit(spans, x, change_at, current);
    x = change_at;
    if (overtake.to != kNone && overtake.at == change_at && change_at < stop) {
      current = overtake.to;
      overtake = NextOvertake(segments, current, x);
    } else {
      current = kNone;
    }
  }
}

}  // namespace shutterline::engine
