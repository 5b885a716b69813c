#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "worker/engine/visibility/envelope.h"

namespace shutterline::engine {

/// The visible spans of a line at an instant, from segments that are offered front to back in order of
/// a bound on their depth: once the nearest so far cover the line without a gap, all that is known to
/// lie behind them need not be made at all. Whether something is hidden is decided on what is visible
/// *jointly*, so a wall of small triangles hides as well as one large.
///
/// Use: Begin, then while Wants(bound) Offer(segment), then Finish. One object per thread.
class FrontToBack {
 public:
  void Begin(int32_t begin, int32_t end);

  /// False once nothing whose depth is at most `nearest_depth` can be visible.
  bool Wants(double nearest_depth) const { return nearest_depth >= hidden_below_; }

  void Offer(const LineSegment& segment, const SegmentPosition& position);

  /// Resolves what was offered. Afterwards spans() are final and segments() holds what they refer to.
  void Finish();

  const std::vector<VisibleSpan>& spans() const { return spans_; }
  const std::vector<LineSegment>& segments() const { return segments_; }
  const std::vector<SegmentPosition>& positions() const { return positions_; }
  /// Depths below this are hidden all along the line; minus infinity where it has a gap.
  double hidden_below() const { return hidden_below_; }

 private:
  /// Marches, and keeps the segments that are visible: what is hidden now stays hidden.
  void Compact();

  /// Large enough that an ordinary line is marched once, small enough to notice a wall early.
  static constexpr size_t kFirstBatch = 64;

  int32_t begin_ = 0, end_ = 0;
  size_t next_compaction_ = kFirstBatch;
  double hidden_below_ = -std::numeric_limits<double>::infinity();
  std::vector<LineSegment> segments_;
  std::vector<SegmentPosition> positions_;
  std::vector<VisibleSpan> spans_;
  std::vector<uint32_t> new_index_;
  EnvelopeMarcher marcher_;
};

}  // namespace shutterline::engine
