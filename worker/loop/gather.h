#pragma once

#include <absl/time/time.h>

#include <cstddef>

namespace shutterline::worker {

/// When results that wait for company are sent. A message costs the coordinator as much as several tiles in
/// one, so it says how long they may wait; but none waits where that could hold up a frame, or whoever wants
/// to know what a worker was at when it died. Pure logic, times handed in: real workers and simulated ones go
/// by it. Not thread-safe.
///
///     (SetPace | Add | Hurry | Remove)*
class Gather {
 public:
  static constexpr size_t kEnoughResults =
      16;  ///< More in a message cost the coordinator hardly less a tile.
  static constexpr absl::Duration kLongest = absl::Seconds(1);  ///< Whatever the coordinator says.

  /// How long a result may wait from now on. What makes no sense is brought into bounds.
  void SetPace(absl::Duration pace);
  absl::Duration pace() const { return pace_; }

  /// A result has come.
  void Add(size_t bytes, absl::Duration now);
  /// What waits has waited for long enough: nothing of a frame is left to render, or somebody must know soon.
  /// False where nothing waits.
  bool Hurry() { return hurry_ = results_ > 0; }
  /// A result has been sent, or is not wanted any more.
  void Remove(size_t bytes);

  /// When what waits is to be sent: in the past where it is late, never where nothing waits. `enough_bytes`
  /// do not wait for more.
  absl::Duration Due(size_t enough_bytes) const;

 private:
  absl::Duration pace_;
  size_t results_ = 0, bytes_ = 0;
  absl::Duration since_;  ///< When the first of those that wait came, or what it was sent with.
  bool hurry_ = false;
};

}  // namespace shutterline::worker
