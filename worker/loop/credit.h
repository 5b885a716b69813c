#pragma once

#include <cstddef>

namespace shutterline::worker {

/// For how many more leases a worker asks that has `held`: unrendered ones, and those that it has asked for.
/// It keeps 3 a slot, and `extra`: one renders, the others hide the way to the coordinator and back. It asks
/// when fewer than 2 a slot are left, or, where results take its wish `along`, with every batch.
inline size_t LeasesToAskFor(size_t held, size_t slots, size_t extra, bool along) {
  const size_t full = 3 * slots + extra;
  const size_t enough = along ? full : 2 * slots + extra;
  return held < enough ? full - held : 0;
}

/// Whether a wish may wait until results that are sent now take it along, though they may be held up: every
/// thread has something to do.
inline bool MayGoWithResults(size_t held, size_t slots) {
  return held >= slots;
}

}  // namespace shutterline::worker
