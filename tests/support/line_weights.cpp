#include "tests/support/line_weights.h"

#include <algorithm>
#include <cstring>

namespace shutterline::engine {

LineWeights::Slot& LineWeights::SlotOf(uint32_t index) {
  uint32_t& slot = slot_of_[index];
  if (slot == kNoSlot) {
    slot = uint32_t(slots_.size());
    Slot& fresh = slots_.emplace_back();
    fresh.index = index;
    fresh.first_step = kMaxLinePixels;
    fresh.last_step = -1;
    std::memset(fresh.part, 0, sizeof(fresh.part));
    std::memset(fresh.full, 0, sizeof(fresh.full));
  }
  return slots_[slot];
}

void LineWeights::Add(uint32_t index, int32_t begin, int32_t end, uint64_t weight) {
  Slot& slot = SlotOf(index);
  const int first = begin >> kSubpixelBits;
  const int last = (end - 1) >> kSubpixelBits;
  slot.first_step = std::min(slot.first_step, first);
  slot.last_step = std::max(slot.last_step, last);
  if (first == last) {
    slot.part[first] += uint64_t(end - begin) * weight;
    return;
  }
  slot.part[first] += uint64_t(((first + 1) << kSubpixelBits) - begin) * weight;
  slot.part[last] += uint64_t(end - (last << kSubpixelBits)) * weight;
  slot.full[first + 1] += uint64_t{kSubpixelsPerPixel} * weight;
  slot.full[last] -= uint64_t{kSubpixelsPerPixel} * weight;
}

}  // namespace shutterline::engine
