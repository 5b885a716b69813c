#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "worker/engine/occlusion/line_measure.h"

namespace shutterline::engine {

/// A stretch of a line sample, in its integer positions.
struct LineInterval {
  int32_t begin = 0, end = 0;
};

/// The union of intervals of a line sample, which does not depend on the order in which they come.
class LineCover {
 public:
  void Clear() { intervals_.clear(); }
  /// `begin` <= `end`; what is empty adds nothing.
  void Add(int32_t begin, int32_t end);

  bool Holds(int32_t begin, int32_t end) const {
    for (const LineInterval& interval : intervals_) {
      if (interval.end >= end) return interval.begin <= begin;
    }
    return false;
  }
  bool IsFull() const {
    return intervals_.size() == 1 && intervals_[0].begin == -kLineEnd && intervals_[0].end == kLineEnd;
  }
  /// Disjoint, with gaps between them, from left to right.
  std::span<const LineInterval> intervals() const { return intervals_; }

 private:
  std::vector<LineInterval> intervals_;
};

}  // namespace shutterline::engine
