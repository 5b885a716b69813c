#pragma once

#include <optional>
#include <string>

#include "common/base/dial_security.h"
#include "worker/engine/shading/shading_cache.h"
#include "worker/worker.h"

namespace shutterline::worker {

/// What the command line of shutterline-worker says.
struct Config {
  std::string coordinator;  ///< "HOST:PORT".
  DialSecurity security;
  std::string log_level = "info", log_format = "text";
  WorkerOptions worker;
  uint64_t memory_bytes = 0;  ///< What the process may take; 0: what the machine gives.
  bool supervise = true;      ///< In a process of its own, started again where it dies.
  uint64_t shading_cache_bytes = engine::kDefaultShadingCacheBytes;  ///< 0: none.
};

/// Reads the command line. Nothing where the program is to end at once, with `exit_code`: 0 after --help or
/// --version, 2 for wrong usage, which has been explained on standard error.
std::optional<Config> ParseCommandLine(int argc, const char* const* argv, int& exit_code);

/// $XDG_CACHE_HOME/shutterline/blobs, or below ~/.cache, or below the folder for temporary files.
std::filesystem::path DefaultCacheDir();

}  // namespace shutterline::worker
