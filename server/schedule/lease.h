#pragma once

#include <absl/time/time.h>

#include <cstdint>
#include <string>
#include <vector>

#include "server/schedule/tile_trouble.h"

namespace shutterline::server {

using JobKey = uint64_t;    ///< A job's number in the store; smaller is older.
using WorkerId = uint64_t;  ///< One registration of a worker. Never reused within an epoch.
using LeaseId = uint64_t;   ///< Never reused within an epoch.

/// The right of a worker to render some tiles of one frame, until it expires.
struct Lease {
  LeaseId id = 0;
  WorkerId worker = 0;
  JobKey job = 0;
  int frame = 0;  ///< Index into the job's frames.
  std::vector<uint32_t> tiles;
  int outstanding = 0;      ///< Tiles that neither came back nor failed.
  absl::Duration deadline;  ///< Monotonic, as the next.
  absl::Duration granted;
  /// When its latest tile came back, or was granted: since then nothing has been heard of its work.
  absl::Duration progressed;
  bool send_at_once = false;  ///< Some of its tiles were leased before: see Grant.send_at_once.
  double charged = 0;         ///< Seconds a tile that its job has been charged for (FairShare).
};

struct EndedLease {
  LeaseId id = 0;
  WorkerId worker = 0;
};

/// A tile of a lease that goes on without it.
struct DroppedTile {
  LeaseId lease = 0;
  WorkerId worker = 0;
  uint32_t tile = 0;
};

/// A tile that is not tried any more, and why.
struct Quarantined {
  JobKey job = 0;
  int frame = 0;  ///< Index into the job's frames.
  uint32_t tile = 0;
  std::vector<TileTrouble> evidence;  ///< Oldest first.
};

}  // namespace shutterline::server
