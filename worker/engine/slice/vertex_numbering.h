#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace shutterline::engine {

/// Numbers keys 0, 1, 2, ... as they come for the first time: a hash table that is emptied in constant time
/// and keeps its memory. Not thread-safe.
class VertexNumbering {
 public:
  /// Forgets all keys, and makes room for `most` of them.
  void Reset(size_t most) {
    count_ = 0;
    size_t wanted = 64;
    while (wanted < 2 * most) wanted *= 2;
    if (wanted > slots_.size() || ++generation_ == 0) {
      slots_.assign(std::max(wanted, slots_.size()), {});
      generation_ = 1;
    }
    mask_ = slots_.size() - 1;
  }

  /// The key's number; `is_new` tells whether it came for the first time.
  uint32_t NumberOf(uint32_t key, bool& is_new) {
    // Fibonacci hashing spreads runs of neighbouring vertices.
    for (size_t at = (key * uint64_t{0x9E3779B97F4A7C15} >> 20) & mask_;; at = (at + 1) & mask_) {
      Slot& slot = slots_[at];
      if (slot.generation != generation_) {
        slot = {key, count_, generation_};
        is_new = true;
        return count_++;
      }
      if (slot.key == key) {
        is_new = false;
        return slot.number;
      }
    }
  }

  uint32_t count() const { return count_; }

 private:
  struct Slot {
    uint32_t key = 0, number = 0, generation = 0;
  };
  std::vector<Slot> slots_;
  size_t mask_ = 0;
  uint32_t generation_ = 0;
  uint32_t count_ = 0;
};

}  // namespace shutterline::engine
