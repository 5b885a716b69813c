#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace shutterline::worker {

/// A tile that a thread is at.
struct TileAtHand {
  std::string job_id;
  int frame = 0;
  uint32_t tile = 0;
  friend bool operator==(const TileAtHand&, const TileAtHand&) = default;
};

/// How an earlier process of this worker ended: evidence for whoever looks for the tile that it died of.
struct WorkerExit {
  std::string boot_id;
  int signal = 0;
  std::string log_tail;  ///< Its last lines, valid UTF-8 without control characters but newlines.
  std::vector<TileAtHand> tiles;
};

}  // namespace shutterline::worker
