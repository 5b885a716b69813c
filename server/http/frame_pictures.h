#pragma once

#include <absl/base/thread_annotations.h>
#include <absl/status/statusor.h>
#include <absl/synchronization/mutex.h>

#include <cstdint>
#include <string>
#include <vector>

#include "server/assemble/tile_journal.h"
#include "server/control/farm.h"

namespace shutterline::server {

/// Frames as PNGs for people, in sRGB as the client's previews. Thread-safe.
class FramePictures {
 public:
  static constexpr size_t kMaxTiles = 256;                 ///< Of a strip.
  static constexpr int64_t kMaxPixels = int64_t{1} << 26;  ///< Of a finished frame that is shown.
  static constexpr int kMinSide = 32, kMaxSide = 4096;

  explicit FramePictures(const TileJournal& journal) : journal_(journal) {}

  struct Strip {
    std::string png;
    std::vector<uint32_t> tiles;  ///< Which are in it, from the top.
  };
  /// Tiles of an unfinished frame, one below the other, each in the top left of a square of kTileSize. Tiles
  /// that are not there are left out; NOT_FOUND where none is.
  absl::StatusOr<Strip> Tiles(const Farm::FrameView& view, const std::vector<uint32_t>& tiles) const;

  /// The finished frame, reduced by a whole number so that no side is longer than `side`.
  /// RESOURCE_EXHAUSTED beyond kMaxPixels. One at a time: a frame takes much memory.
  absl::StatusOr<std::string> Finished(const Farm::FrameView& view, int side);

 private:
  const TileJournal& journal_;
  absl::Mutex one_at_a_time_;
};

}  // namespace shutterline::server
