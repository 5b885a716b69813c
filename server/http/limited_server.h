#pragma once

#include <absl/time/time.h>
#include <httplib.h>

#include <cstddef>

namespace shutterline::server {

/// The HTTP library's server with bounds that it lacks: one request a connection, which must have come within
/// a time and a number of bytes, and as many connections at once as there are threads; others wait in the
/// system's queue.
class LimitedServer final : public httplib::Server {
 public:
  struct Limits {
    size_t threads = 24;
    size_t request_bytes = 32 << 10;  ///< Request line, headers and body.
    absl::Duration request_time = absl::Seconds(10);
    absl::Duration write_time = absl::Seconds(10);  ///< Without any progress.
  };
  explicit LimitedServer(const Limits& limits);
  ~LimitedServer() override;

 private:
  bool process_and_close_socket(socket_t socket) override;

  const Limits limits_;
};

}  // namespace shutterline::server
