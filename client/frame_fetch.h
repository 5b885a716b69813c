#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <functional>
#include <string>

#include "client/connection.h"
#include "common/asset/digest.h"

namespace shutterline::client {

/// A frame's EXR on this machine.
struct FetchedFrame {
  int frame = 0;
  std::string path;
  uint64_t bytes = 0;
  Digest digest;
  std::string preview;  ///< The PNG's path; empty where none was asked for.
};

/// Fetches a finished frame's EXR into `path`: in pieces, going on at the offset reached when the
/// connection drops (also where an earlier process was interrupted), verified against the digest that the
/// coordinator names, and renamed into place, so that `path` never holds half a file. With `png`, writes
/// its preview beside it.
///
/// FAILED_PRECONDITION while the frame is unfinished, DATA_LOSS where the bytes do not match their digest
/// (twice, if the first time began with what an earlier process left).
absl::StatusOr<FetchedFrame> FetchFrame(Connection& connection, const std::string& job_id, int frame,
                                        const std::string& path, bool png);

}  // namespace shutterline::client
