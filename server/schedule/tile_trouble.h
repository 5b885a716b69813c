#pragma once

#include <absl/time/time.h>

#include <string>

namespace shutterline::server {

/// What went wrong with a tile, once: evidence for people.
struct TileTrouble {
  std::string worker_uuid, worker_name;
  bool worker_ended = false;  ///< It ended while it rendered the tile; otherwise it reported a failure.
  std::string reason;
  absl::Time when;
  std::string signal = {};    ///< That ended it, as "SIGSEGV"; empty: none, or nobody has told.
  std::string log_tail = {};  ///< The last lines of its log; empty: nobody has told.
  std::string boot_id = {};   ///< Of the process that ended. Not stored.

  friend bool operator==(const TileTrouble&, const TileTrouble&) = default;
};

/// What is known of the end of a worker's process.
struct ProcessEnd {
  std::string boot_id, signal, log_tail;

  /// Notes it in a trouble that this process is held for. False where it is another's, or noted already.
  bool AddTo(const std::string& worker_uuid, TileTrouble& trouble) const {
    if (!trouble.worker_ended || trouble.worker_uuid != worker_uuid || trouble.boot_id != boot_id ||
        !trouble.signal.empty()) {
      return false;
    }
    trouble.signal = signal;
    trouble.log_tail = log_tail;
    trouble.reason += ": " + signal;
    return true;
  }
};

}  // namespace shutterline::server
