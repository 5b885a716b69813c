#pragma once

#include <absl/base/thread_annotations.h>
#include <absl/status/statusor.h>
#include <absl/synchronization/mutex.h>

#include <cstdint>
#include <string>
#include <vector>

#include "common/job/job_spec.h"
#include "common/job/tile.h"
#include "server/assemble/tile_journal.h"

namespace shutterline::server {

/// Tiles of frames reduced to a few means each, for pictures that show a frame while it is rendered.
/// Thread-safe.
class FrameThumbnails {
 public:
  static constexpr int64_t kMaxPixels = int64_t{1} << 26;  ///< Of a finished frame, which is read as a whole.

  explicit FrameThumbnails(const TileJournal& journal) : journal_(journal) {}

  struct Tile {
    uint32_t index = 0;
    /// side × side means, rows from the top: linear premultiplied R, G, B, A. The tile's own width and height
    /// are cut into `side` parts each, also where it is cut at the frame's border.
    std::vector<float> rgba;
  };

  /// Tiles of an unfinished frame that are in the journal and not in `known` (by tile).
  absl::StatusOr<std::vector<Tile>> Unfinished(const JobSpec& spec, const TileJournal::FrameKey& frame,
                                               const std::vector<bool>& known, int side) const;
  /// Those of a finished one, from its file. RESOURCE_EXHAUSTED beyond kMaxPixels. One at a time: a frame
  /// takes much memory. Reads nothing where all are known.
  absl::StatusOr<std::vector<Tile>> Finished(const JobSpec& spec, const std::string& path,
                                             const std::vector<bool>& known, int side);

 private:
  const TileJournal& journal_;
  absl::Mutex one_at_a_time_;
};

}  // namespace shutterline::server
