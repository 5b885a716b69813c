#pragma once

#include <absl/status/status.h>

#include <cstdint>
#include <string>
#include <vector>

namespace shutterline::server {

/// A tile as workers name it.
struct TileName {
  std::string job_id;
  int frame = 0;  ///< The frame's number.
  uint32_t tile = 0;
};

/// A process of a worker that a signal ended, as the worker's supervisor has seen it.
struct WorkerExit {
  std::string boot_id;
  int signal = 0;
  std::string log_tail;
  std::vector<TileName> tiles;  ///< What it was at.
};

inline constexpr size_t kMaxWorkerExits = 4;  ///< Of a Hello.

/// INVALID_ARGUMENT, naming the field, where it breaks a rule of the protocol.
absl::Status Validate(const WorkerExit& exit);

/// "SIGSEGV"; "signal 40" where it has no name of its own.
std::string SignalName(int signal);

}  // namespace shutterline::server
