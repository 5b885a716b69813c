#pragma once

namespace shutterline::server {

/// What acknowledged data outlives. The order of operations is the same for both; only whether one waits for
/// the disk differs, so a file that readers see is whole either way.
enum class Durability {
  kProcess,  ///< The end of the process, however abrupt: what was written lies with the kernel.
  kPower,    ///< A loss of power as well: what was written has been flushed to the disk.
};

}  // namespace shutterline::server
