#include "server/config/config.h"

#include <absl/strings/str_cat.h>

#include "common/base/host_port.h"
#include "common/base/status_macros.h"

namespace shutterline::server {
namespace {

bool IsHostAndPort(absl::string_view text) {
  const size_t colon = text.rfind(':');
  if (colon == absl::string_view::npos || colon == 0) return false;
  const std::string port(text.substr(colon + 1));
  return !port.empty() && port.size() <= 5 && port.find_first_not_of("0123456789") == std::string::npos &&
         std::stoi(port) <= 65535;
}

}  // namespace

absl::Status Validate(const Config& c) {
  const auto refuse = [](absl::string_view field, absl::string_view reason) {
    return absl::InvalidArgumentError(absl::StrCat("coordinator configuration: ", field, " ", reason));
  };
  if (c.data_dir.empty()) return refuse("data_dir", "is empty");
  if (!c.listen.empty() && !IsHostAndPort(c.listen))
    return refuse("listen", absl::StrCat("'", c.listen, "' is not HOST:PORT"));
  if (!c.http.empty() && !IsHostAndPort(c.http))
    return refuse("http", absl::StrCat("'", c.http, "' is not HOST:PORT"));
  if (!c.http.empty() && !c.insecure_listen && !IsLoopback(HostOf(c.http))) {
    return refuse("http",
                  absl::StrCat("'", c.http,
                               "' can be reached by other machines, but nothing would be encrypted; use "
                               "127.0.0.1, or insecure_listen in a trusted network"));
  }
  if (!c.listen.empty()) {
    const bool loopback = IsLoopback(HostOf(c.listen));
    SL_RETURN_IF_ERROR(Annotate(Validate(c.security, loopback), "coordinator configuration"));
    if (!c.insecure_listen && !c.security.encrypts() && !loopback) {
      return refuse("listen",
                    absl::StrCat("'", c.listen,
                                 "' can be reached by other machines, but nothing would be encrypted "
                                 "or authenticated; use 127.0.0.1, or tls_cert, tls_key and "
                                 "tls_client_ca, or insecure_listen in a trusted network"));
    }
  }
  if (c.heartbeat_interval <= absl::ZeroDuration()) return refuse("heartbeat_interval", "must be above 0");
  if (c.lease_ttl < 2 * c.heartbeat_interval)
    return refuse("lease_ttl", "must be at least two heartbeat intervals");
  if (c.stream_grace < absl::ZeroDuration()) return refuse("stream_grace", "must not be negative");
  if (c.adoption_time < absl::ZeroDuration()) return refuse("adoption_time", "must not be negative");
  if (c.speculate_after <= absl::ZeroDuration()) return refuse("speculate_after", "must be above 0");
  if (c.batch_time <= absl::ZeroDuration()) return refuse("batch_time", "must be above 0");
  if (c.commit_interval < absl::ZeroDuration()) return refuse("commit_interval", "must not be negative");
  if (c.commit_tiles < 1) return refuse("commit_tiles", "must be at least 1");
  if (c.scene_time <= absl::ZeroDuration()) return refuse("scene_time", "must be above 0");
  if (c.max_tile_failures < 1) return refuse("max_tile_failures", "must be at least 1");
  if (c.max_tile_deaths < 1) return refuse("max_tile_deaths", "must be at least 1");
  if (c.max_message_bytes < 1 << 20) return refuse("max_message_bytes", "must be at least 1 MiB");
  if (c.keep_jobs < absl::ZeroDuration()) return refuse("keep_jobs", "must not be negative");
  if (c.keep_jobs_max < 0) return refuse("keep_jobs_max", "must not be negative");
  if (c.removal_interval <= absl::ZeroDuration()) return refuse("removal_interval", "must be above 0");
  const StreamConfig& s = c.streams;
  if (s.first_message <= absl::ZeroDuration()) return refuse("streams.first_message", "must be above 0");
  if (s.upload_stall <= absl::ZeroDuration()) return refuse("streams.upload_stall", "must be above 0");
  for (const int limit :
       {s.max_streams_per_connection, s.max_sessions, s.max_watches, s.max_uploads, s.max_downloads}) {
    if (limit < 1) return refuse("streams", "each limit must be at least 1");
  }
  if (s.max_buffer_bytes < uint64_t(c.max_message_bytes)) {
    return refuse("streams.max_buffer_bytes", "must be at least max_message_bytes");
  }
  return absl::OkStatus();
}

}  // namespace shutterline::server
