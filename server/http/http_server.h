#pragma once

#include <absl/status/statusor.h>

#include <memory>
#include <string>
#include <vector>

#include "common/base/clock.h"
#include "server/assemble/tile_journal.h"
#include "server/control/farm.h"
#include "server/http/request_guard.h"
#include "server/observe/metrics.h"
#include "server/observe/throughput.h"
#include "server/observe/timeline.h"

namespace shutterline::server {

/// The coordinator over HTTP: /healthz, /metrics, a JSON API with events (docs/observability.md), and the
/// dashboard that uses it. Thread-safe.
class HttpServer {
 public:
  /// What it shows; all of it outlives the server.
  struct Parts {
    std::string listen;              ///< "HOST:PORT", as Validate(Config) has found it good.
    std::vector<std::string> names;  ///< Under which it may be asked for, beside addresses and localhost.
    MayControl may_control = LoopbackMayControl;
    const Clock* clock = nullptr;
    Farm* farm = nullptr;
    const TileJournal* journal = nullptr;
    Metrics* metrics = nullptr;
    const Timeline* timeline = nullptr;
    const Throughput* throughput = nullptr;
    std::string build_id;
  };
  /// UNAVAILABLE where the address cannot be bound.
  static absl::StatusOr<std::unique_ptr<HttpServer>> Start(Parts parts);
  ~HttpServer();  ///< Stop.
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  int port() const;
  /// Ends streams and serves no more; returns when the last answer is out. Later calls do nothing.
  void Stop();

 private:
  class Impl;
  explicit HttpServer(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace shutterline::server
