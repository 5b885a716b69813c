#include "worker/engine/visibility/front_to_back.h"

#include <algorithm>

namespace shutterline::engine {

void FrontToBack::Begin(int32_t begin, int32_t end) {
  begin_ = begin;
  end_ = end;
  next_compaction_ = kFirstBatch;
  hidden_below_ = -std::numeric_limits<double>::infinity();
  segments_.clear();
  positions_.clear();
  spans_.clear();
}

void FrontToBack::Offer(const LineSegment& segment, const SegmentPosition& position) {
  segments_.push_back(segment);
  positions_.push_back(position);
  if (segments_.size() < next_compaction_) return;
  Compact();
  // Doubling keeps the work of all marches within a constant factor of the last one.
  next_compaction_ = std::max(kFirstBatch, 2 * segments_.size());
}

void FrontToBack::Finish() {
  Compact();
}

void FrontToBack::Compact() {
  marcher_.March(segments_, begin_, end_, spans_);

  // Keep what is visible, in its order.
  constexpr uint32_t kHidden = std::numeric_limits<uint32_t>::max();
  new_index_.assign(segments_.size(), kHidden);
  for (const VisibleSpan& span : spans_) new_index_[span.segment] = 0;
  uint32_t kept = 0;
  for (uint32_t i = 0; i < segments_.size(); ++i) {
    if (new_index_[i] == kHidden) continue;
    segments_[kept] = segments_[i];
    positions_[kept] = positions_[i];
    new_index_[i] = kept++;
  }
  segments_.resize(kept);
  positions_.resize(kept);

  // Without a gap, the farthest visible depth hides all that lies behind it.
  int32_t covered = begin_;
  double farthest = std::numeric_limits<double>::infinity();
  for (VisibleSpan& span : spans_) {
    span.segment = new_index_[span.segment];
    covered += span.end - span.begin;
    const LineSegment& segment = segments_[span.segment];
    farthest = std::min({farthest, segment.DepthAt(span.begin / double(kSubpixelsPerPixel)),
                         segment.DepthAt(span.end / double(kSubpixelsPerPixel))});
  }
  if (covered == end_) hidden_below_ = std::max(hidden_below_, farthest);
}

}  // namespace shutterline::engine
