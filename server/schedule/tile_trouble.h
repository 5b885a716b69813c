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

  friend bool operator==(const TileTrouble&, const TileTrouble&) = default;
};

}  // namespace shutterline::server
