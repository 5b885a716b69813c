#pragma once

#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>
#include <absl/time/time.h>

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "server/schedule/lease.h"
#include "server/schedule/worker_exit.h"

namespace shutterline::server {

/// Who a worker says it is.
struct WorkerHello {
  std::string uuid, boot_id, build_id, isa, name;
  uint32_t protocol_low = 0, protocol_high = 0;
  int64_t slots = 0;
  std::vector<WorkerExit> exits;
};

/// What this coordinator is, for comparison.
struct CoordinatorIdentity {
  std::string build_id;
  uint32_t protocol_low = 0, protocol_high = 0;
};

/// One registration of a worker.
struct WorkerEntry {
  WorkerId id = 0;
  std::string session_id;  ///< A UUID; what the worker shows in its streams.
  WorkerHello hello;
  uint32_t protocol = 0;                  ///< Spoken with it.
  absl::Duration registered, last_heard;  ///< Monotonic.
  bool attached = false;                  ///< Its Session stream is open.
  bool draining = false;
  int64_t credit = 0;  ///< Leases that it still wants.
  int64_t tiles_done = 0;
};

/// Who is registered. Not thread-safe.
class WorkerRegistry {
 public:
  explicit WorkerRegistry(CoordinatorIdentity identity) : identity_(std::move(identity)) {}

  /// A new registration. INVALID_ARGUMENT for a hello that breaks a rule, FAILED_PRECONDITION where build or
  /// protocol do not agree (the message names both sides), RESOURCE_EXHAUSTED where there are too many.
  absl::StatusOr<WorkerEntry*> Register(const WorkerHello& hello, absl::Duration now);
  WorkerEntry* Find(WorkerId id);
  WorkerEntry* FindSession(absl::string_view session_id);
  /// Earlier registrations of the same worker by another process: that process is gone.
  std::vector<WorkerId> Predecessors(const WorkerEntry& entry) const;
  /// Earlier registrations of the same process: it has given them up.
  std::vector<WorkerId> Siblings(const WorkerEntry& entry) const;
  void Remove(WorkerId id);

  const std::map<WorkerId, WorkerEntry>& entries() const { return entries_; }

 private:
  const CoordinatorIdentity identity_;
  std::map<WorkerId, WorkerEntry> entries_;
  std::map<std::string, WorkerId> by_session_;
  WorkerId next_ = 1;
};

}  // namespace shutterline::server
