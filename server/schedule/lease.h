#pragma once

#include <absl/time/time.h>

#include <cstdint>
#include <string>
#include <vector>

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
  absl::Duration deadline;  ///< Monotonic.
};

struct EndedLease {
  LeaseId id = 0;
  WorkerId worker = 0;
};

/// A tile that cannot be rendered, and why: its job has failed.
struct PoisonedTile {
  JobKey job = 0;
  int frame = 0;
  uint32_t tile = 0;
  std::string reason;
};

}  // namespace shutterline::server
