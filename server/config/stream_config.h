#pragma once

#include <absl/time/time.h>

#include <cstdint>

namespace shutterline::server {

/// What streams may take of a coordinator. Each open stream costs some 20 KB, and what it is about to say.
struct StreamConfig {
  absl::Duration first_message = absl::Seconds(10);  ///< Within which Session and PushResults must say who.
  absl::Duration upload_stall = absl::Seconds(60);   ///< Longest time between two chunks of a Write.
  int max_streams_per_connection = 128;              ///< Those beyond wait at their client.
  int max_sessions = 4096;                           ///< As many for results.
  int max_watches = 1024;                            ///< Watch and ReadTiles.
  int max_uploads = 256;
  int max_downloads = 1024;  ///< Blobs.Read, FetchFrame, ReadLog and ReadTrace together.
  uint64_t max_uploading_bytes = uint64_t{64} << 30;  ///< Announced by uploads in progress, all together.
  /// For messages that come and go, in gRPC's own buffers: beyond it calls end with RESOURCE_EXHAUSTED.
  uint64_t max_buffer_bytes = uint64_t{1} << 30;
};

}  // namespace shutterline::server
