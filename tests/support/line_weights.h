#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/math/tolerance.h"

namespace shutterline::engine {

/// Weights of one line's spans, gathered over all its instants before they go to the pixels' pairs.
///
/// At every instant a triangle covers about the same pixels again, so a span is not cut at the pixels'
/// borders each time: it is noted by its ends in a difference buffer of its triangle, at a price that does
/// not depend on its length, and the pixels' weights are summed up once a line. All numbers are integers,
/// so nothing is lost by that. For triangles whose pairs need no position; see PairWeights.
class LineWeights {
 public:
  /// Begins a tile of `triangles` triangles; what has been added must have been flushed.
  void Reset(size_t triangles) { slot_of_.assign(triangles, kNoSlot); }

  /// Adds the span [begin, end) (subpixels) of triangle `index` with a weight per subpixel.
  void Add(uint32_t index, int32_t begin, int32_t end, uint64_t weight);

  /// True once so many triangles are held that it is time to flush, before their buffers fill memory.
  bool Full() const { return slots_.size() >= 1024; }

  /// Calls flush(index, step, weight) for every step of the line in which a triangle has weight, in the
  /// order in which triangles first came, and forgets all.
  template <typename Flush>
  void ForEachAndClear(const Flush& flush);

 private:
  static constexpr uint32_t kNoSlot = ~uint32_t{0};

  /// Step s's weight is part[s] + Σ_{i <= s} full[i]: the difference buffer wraps around zero, and its
  /// sums come out right.
  struct Slot {
    uint32_t index;
    int first_step, last_step;
    uint64_t part[kMaxLinePixels + 1];
    uint64_t full[kMaxLinePixels + 1];
  };

  Slot& SlotOf(uint32_t index);

  std::vector<uint32_t> slot_of_;  // By triangle.
  std::vector<Slot> slots_;
};

template <typename Flush>
void LineWeights::ForEachAndClear(const Flush& flush) {
  for (const Slot& slot : slots_) {
    uint64_t full = 0;
    for (int step = slot.first_step; step <= slot.last_step; ++step) {
      full += slot.full[step];
      const uint64_t weight = slot.part[step] + full;
      if (weight != 0) flush(slot.index, step, weight);
    }
    slot_of_[slot.index] = kNoSlot;
  }
  slots_.clear();
}

}  // namespace shutterline::engine
