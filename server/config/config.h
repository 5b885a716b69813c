#pragma once

#include <absl/status/status.h>
#include <absl/time/time.h>

#include <cstdint>
#include <string>
#include <vector>

#include "common/job/job_spec.h"
#include "server/config/listen_security.h"
#include "server/config/stream_config.h"
#include "server/files/durability.h"

namespace shutterline::server {

/// How a coordinator runs. The defaults suit a farm of a few machines; tests shorten the times.
struct Config {
  /// Where jobs, blobs, journals and frames are kept; made if it does not exist. One coordinator at a time
  /// may use a folder.
  std::string data_dir;
  /// "HOST:PORT" to listen on, port 0 for any free one. Empty: in-process channels only.
  std::string listen;
  /// Permits listening on an address that other machines reach, although nothing is encrypted.
  bool insecure_listen = false;
  ListenSecurity security;

  /// "HOST:PORT" to serve HTTP on: metrics and the dashboard. Port 0: any free one. Empty: not at all.
  std::string http;
  /// Names under which browsers may ask for it, beside addresses and localhost.
  std::vector<std::string> http_names;

  absl::Duration lease_ttl = absl::Seconds(15);           ///< Silence after which tiles are leased again.
  absl::Duration heartbeat_interval = absl::Seconds(5);   ///< Asked of workers.
  absl::Duration stream_grace = absl::Milliseconds(900);  ///< From a stream's end until its leases end.
  /// How long a coordinator that starts waits for workers to come back with tiles that they are at.
  absl::Duration adoption_time = absl::Seconds(10);
  absl::Duration speculate_after = absl::Milliseconds(500);  ///< Tiles of less are not rendered twice.
  absl::Duration batch_time = absl::Milliseconds(250);       ///< Thread time that a lease aims at.
  absl::Duration commit_interval = absl::Milliseconds(5);    ///< Longest wait of a result for company.
  int commit_tiles = 64;                                     ///< Results that are written without waiting.
  /// What the import of a submitted scene may take.
  absl::Duration scene_time = absl::InfiniteDuration();
  int max_tile_failures = 3;  ///< Reported of one tile, after which it is quarantined.
  int max_tile_deaths = 3;    ///< The same of workers that ended while they rendered it.

  /// What acknowledged jobs, tiles, blobs and frames outlive.
  Durability durability = Durability::kPower;
  /// Of all blobs together; 0: no limit. Beyond it those that no live job needs are evicted, least recently
  /// used first.
  uint64_t blob_limit_bytes = 0;

  /// Memory for tiles of unfinished frames that are compressed already; 0: all are compressed when their
  /// frame has all of them, as are those for which there is no room.
  uint64_t frame_block_bytes = uint64_t{256} << 20;

  /// How long jobs are kept that have ended, by the wall clock, with their frames, logs and tiles; by default
  /// for ever.
  absl::Duration keep_jobs = absl::InfiniteDuration();
  int64_t keep_jobs_max = 0;                            ///< How many of them, the latest ones; 0: any number.
  absl::Duration removal_interval = absl::Seconds(10);  ///< How often they are looked at.

  JobLimits job_limits;
  uint64_t max_blob_bytes = uint64_t{2} << 30;
  int max_message_bytes = 16 << 20;  ///< Of one received message.
  StreamConfig streams;
};

/// INVALID_ARGUMENT where a value makes no sense, or `listen` is open to others without encryption and
/// without `insecure_listen`.
absl::Status Validate(const Config& config);

}  // namespace shutterline::server
