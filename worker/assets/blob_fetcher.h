#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <string>

#include "common/asset/digest.h"

namespace shutterline::worker {

/// Where blobs come from that are not on this machine yet.
class BlobFetcher {
 public:
  virtual ~BlobFetcher() = default;

  /// The blob's bytes, not yet compared with the digest. NOT_FOUND where the other side has none,
  /// RESOURCE_EXHAUSTED where it is larger than `max_bytes`. Blocks; may be called from any thread.
  virtual absl::StatusOr<std::string> Fetch(const Digest& digest, uint64_t max_bytes) = 0;
};

}  // namespace shutterline::worker
