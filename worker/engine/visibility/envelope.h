#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "worker/engine/visibility/segment.h"

namespace shutterline::engine {

/// A visible piece of a line: [begin, end) in subpixels shows `segment`, an index into the segments that
/// were given. What no span covers shows the background.
struct VisibleSpan {
  int32_t begin = 0, end = 0;
  uint32_t segment = 0;
};

/// Exact visibility along a line at an instant: the upper envelope (nearest depth) of segments, found by
/// marching from one visible change to the next. Intersecting segments come out cut where they cross.
///
/// At x the nearest segment is known; what is visible changes next at the earliest of its end, the start
/// of a segment that lies nearer there, and its crossing with an active segment that rises faster. There
/// are no tolerances: positions are integers, every step advances by at least one of them, and after a
/// crossing the faster segment is taken without comparing depths again, so rounding can neither loop nor
/// lose a piece. Where depths are equal the faster rising one, then the lower id, is nearer. The result
/// is a function of the *set* of segments: their order does not matter.
///
/// Costs O(n log n) for sorting by start plus, per visible change, the segments active there. Keeps its
/// working memory between calls; one marcher per thread.
class EnvelopeMarcher {
 public:
  /// Replaces `spans` by the visible spans within [begin, end), ascending, not overlapping; neighbours
  /// of the same segment are joined.
  void March(std::span<const LineSegment> segments, int32_t begin, int32_t end,
             std::vector<VisibleSpan>& spans);

 private:
  struct Change {
    int32_t at;
    uint32_t to;
  };

  /// Where `b`, not nearer now, overtakes `a` after x; at >= stop if it does not before `stop`.
  static int32_t OvertakesAt(const LineSegment& a, const LineSegment& b, int32_t x, int32_t stop);
  Change NextOvertake(std::span<const LineSegment> segments, uint32_t current, int32_t x);
  /// The nearest just right of x, none where nothing is.
  uint32_t NearestActive(std::span<const LineSegment> segments, int32_t x) const;
  static bool SoonerChange(std::span<const LineSegment> segments, const Change& a, const Change& b);

  std::vector<uint32_t> by_start_;
  std::vector<uint32_t> active_;
};

/// True if `a` hides `b` just right of subpixel `x`.
bool IsNearer(const LineSegment& a, const LineSegment& b, int32_t x);

}  // namespace shutterline::engine
