#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "common/asset/digest.h"
#include "common/cryptomatte/cryptomatte.h"
#include "common/image/exr.h"
#include "common/job/job_spec.h"
#include "server/assemble/frame_blocks.h"
#include "server/assemble/tile_journal.h"
#include "server/files/durability.h"

namespace shutterline::server {

/// A frame's EXR as it has been written.
struct AssembledFrame {
  Digest digest;
  uint64_t size = 0;  ///< Bytes.
  /// Tiles that the journal holds no longer soundly: nothing was written, they are to be rendered again.
  std::vector<uint32_t> lost_tiles;
};

/// Tells what must be known of a frame beside its tiles.
struct FrameFacts {
  /// What the job's mattes are named after.
  std::function<absl::StatusOr<MatteNames>()> names;
  std::function<absl::StatusOr<CameraMatrices>()> camera;
};

/// Puts the journal's tiles of frame `key` together and writes the EXR to `path`, atomically and as durably
/// as is asked. Of `blocks` those are used that are of the very pixels that the journal has; all others are
/// read, verified and encoded here, by all processors. Tiles of `missing` are left transparent, zero in every
/// channel, and named in the header ("shutterline:missing_tiles", their numbers, a comma between two). Of
/// `facts`, names are asked for if the job has mattes. Equal tiles give equal bytes, whatever their order and
/// wherever they were encoded. RESOURCE_EXHAUSTED: the disk is full, for now; FAILED_PRECONDITION: this
/// machine's memory does not hold the frame. Thread-safe for different frames.
absl::StatusOr<AssembledFrame> AssembleFrame(const TileJournal& journal, const TileJournal::FrameKey& key,
                                             const JobSpec& spec, const std::set<uint32_t>& missing,
                                             FrameBlocks::Blocks blocks, const FrameFacts& facts,
                                             const std::string& path, Durability durability);

}  // namespace shutterline::server
