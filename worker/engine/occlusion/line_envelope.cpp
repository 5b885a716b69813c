#include "worker/engine/occlusion/line_envelope.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "worker/engine/occlusion/line_measure.h"

namespace shutterline::engine {
namespace {

LineDirection DirectionAt(int32_t position) {
  const double l = position * kLineUnit;
  return {l, std::sqrt((1 - l) * (1 + l))};
}

/// The larger is nearer. Values along a line are sinusoids of one period, so two of them cross once at most
/// within a half circle.
double Nearness(const DistanceSegment& segment, const LineDirection& d) {
  return segment.inverse_along * d.along + segment.inverse_up * d.up;
}

/// Where two segments are equally near; between directions at which the one and the other is nearer.
LineDirection Crossing(const DistanceSegment& p, const DistanceSegment& q) {
  double along = p.inverse_up - q.inverse_up, up = q.inverse_along - p.inverse_along;
  if (up < 0) along = -along, up = -up;
  const double length = std::sqrt(along * along + up * up);
  return {along / length, up / length};
}

/// Sweeps a line from left to right; between two neighbouring ends of segments the same ones are there.
class Sweep {
 public:
  explicit Sweep(const FalloffRule& rule) : rule_(rule) {}

  /// Ends the sweep.
  int64_t Sum() {
    ClosePiece();
    return sum_;
  }

  /// All of `active` reach from `begin` to `end`.
  void AddStretch(const std::vector<DistanceSegment>& active, int32_t begin, int32_t end) {
    const LineDirection a = DirectionAt(begin), b = DirectionAt(end);
    // The nearest at the beginning; of equally near ones the nearest at the end.
    const DistanceSegment* nearest = nullptr;
    for (const DistanceSegment& segment : active) {
      if (nearest == nullptr || std::pair(Nearness(segment, a), Nearness(segment, b)) >
                                    std::pair(Nearness(*nearest, a), Nearness(*nearest, b))) {
        nearest = &segment;
      }
    }
    LineDirection from = a;
    while (true) {
      // The first to become nearer; of several at one place, the nearest in the end.
      const DistanceSegment* next = nullptr;
      LineDirection until = b;
      for (const DistanceSegment& segment : active) {
        if (!(Nearness(segment, b) > Nearness(*nearest, b))) continue;
        LineDirection at = Crossing(*nearest, segment);
        if (!(at.along >= from.along)) at = from;
        if (at.along > until.along) at = until;
        if (next == nullptr || at.along < until.along ||
            (at.along == until.along && Nearness(segment, b) > Nearness(*next, b))) {
          next = &segment;
          until = at;
        }
      }
      AddPiece(*nearest, from, until);
      if (next == nullptr) return;
      nearest = next;
      from = until;
    }
  }

 private:
  /// Pieces come from left to right. What is visible on both sides of an end of something hidden is one
  /// piece.
  void AddPiece(const DistanceSegment& segment, const LineDirection& a, const LineDirection& b) {
    if (!(a.along < b.along)) return;
    if (is_open_ && end_.along == a.along && segment.inverse_along == segment_.inverse_along &&
        segment.inverse_up == segment_.inverse_up) {
      end_ = b;
      return;
    }
    ClosePiece();
    is_open_ = true;
    segment_ = segment;
    begin_ = a;
    end_ = b;
  }

  void ClosePiece() {
    if (is_open_) {
      sum_ += std::llround(OcclusionOfPiece(segment_, begin_, end_, rule_) * double(kWholeLine));
    }
    is_open_ = false;
  }

  const FalloffRule& rule_;
  int64_t sum_ = 0;
  bool is_open_ = false;  ///< The latest piece, which may go on.
  DistanceSegment segment_;
  LineDirection begin_, end_;
};

}  // namespace

int64_t OcclusionOfNearest(std::vector<DistanceSegment>& segments, const FalloffRule& rule) {
  const auto key = [](const DistanceSegment& s) {
    return std::tuple(s.begin, s.end, s.inverse_along, s.inverse_up);
  };
  std::sort(segments.begin(), segments.end(),
            [&](const DistanceSegment& a, const DistanceSegment& b) { return key(a) < key(b); });
  Sweep sweep(rule);
  thread_local std::vector<DistanceSegment> active;
  active.clear();
  int32_t at = -kLineEnd;
  for (size_t next = 0; next < segments.size() || !active.empty();) {
    if (active.empty()) at = segments[next].begin;
    while (next < segments.size() && segments[next].begin == at) active.push_back(segments[next++]);
    int32_t until = next < segments.size() ? segments[next].begin : kLineEnd;
    for (const DistanceSegment& segment : active) until = std::min(until, segment.end);
    sweep.AddStretch(active, at, until);
    std::erase_if(active, [&](const DistanceSegment& segment) { return segment.end == until; });
    at = until;
  }
  return std::clamp<int64_t>(sweep.Sum(), 0, kWholeLine);
}

}  // namespace shutterline::engine
