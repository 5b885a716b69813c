#pragma once

#include <absl/strings/string_view.h>
#include <absl/time/time.h>

#include <cstdint>
#include <vector>

#include "server/jobs/job_store.h"
#include "server/schedule/lease.h"

namespace shutterline::server {

/// What became of a tile that a worker reported.
enum class TileOutcome { kStored, kDuplicate, kMismatch, kUnwanted, kRefused, kFailed };

/// Hears what happens on the farm: for metrics and traces. What nobody asks for costs an empty call.
///
/// Calls come from several threads, some under the farm's mutex: implementations are thread-safe, return at
/// once and do not call back. Texts and vectors hold for the call alone. Times are monotonic, of the
/// coordinator's clock.
class FarmObserver {
 public:
  virtual ~FarmObserver() = default;

  struct Granted {
    LeaseId lease = 0;
    WorkerId worker = 0;
    absl::string_view worker_uuid, worker_name, job_id;
    int frame = 0;  ///< The frame's number.
    const std::vector<uint32_t>& tiles;
    absl::Duration at;
  };
  virtual void OnGranted(const Granted&) {}

  enum class LeaseEnd { kExpired, kRevoked, kReturned };
  /// Leases that ended otherwise than by their tiles.
  virtual void OnLeasesEnded(LeaseEnd, int64_t /*leases*/) {}

  /// Of every tile that was reported, once; what is said is on disk.
  virtual void OnTile(TileOutcome) {}

  /// A tile that is stored, the first time that it came.
  struct TileStored {
    absl::string_view job_id;
    int frame = 0;
    uint32_t tile = 0;
    WorkerId worker = 0;
    absl::Duration received, durable;
    absl::Duration render_time;  ///< As the worker says.
  };
  virtual void OnTileStored(const TileStored&) {}

  /// A group of results has been flushed to the journal.
  struct Committed {
    int64_t tiles = 0;          ///< In the group, whatever became of them.
    int64_t journal_bytes = 0;  ///< Pixels of those that were stored.
    absl::Duration longest;     ///< From the arrival of the group's oldest result until it was durable.
    bool failed = false;
  };
  virtual void OnCommitted(const Committed&) {}

  struct FrameWritten {
    absl::string_view job_id;
    int frame = 0;
    uint64_t bytes = 0;
    absl::Duration began, ended;
  };
  virtual void OnFrameWritten(const FrameWritten&) {}

  virtual void OnJobAccepted(absl::string_view /*job_id*/) {}
  virtual void OnJobEnded(absl::string_view /*job_id*/, JobState) {}
  virtual void OnJobRemoved(absl::string_view /*job_id*/) {}
};

}  // namespace shutterline::server
