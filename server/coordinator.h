#pragma once

#include <absl/status/statusor.h>
#include <absl/time/time.h>

#include <memory>
#include <string>

#include "common/base/clock.h"
#include "server/config/config.h"

namespace grpc {
class Channel;
}
namespace shutterline::engine {
class SceneShelf;
}

namespace shutterline::server {

/// A whole coordinator: durable jobs, blobs, leases, assembled frames, and the gRPC services over them
/// (Jobs, Blobs, Workers, health, reflection). Runs on a listening port, in-process, or both.
///
///     server::Config config;
///     config.data_dir = folder;                    // no `listen`: nothing but this process reaches it
///     SL_ASSIGN_OR_RETURN(auto coordinator, server::Coordinator::Start(config));
///     auto jobs = v1::Jobs::NewStub(coordinator->InProcessChannel());
///
/// Thread-safe. Whatever it has acknowledged survives its end, however abrupt.
class Coordinator {
 public:
  /// Opens or makes the data folder, takes up unfinished jobs and starts to serve. FAILED_PRECONDITION where
  /// another coordinator uses the folder, UNAVAILABLE where the address cannot be bound, INVALID_ARGUMENT
  /// for a bad configuration, DATA_LOSS for a damaged store. Scenes that were checked are put on `shelf`,
  /// which outlives the coordinator, or may be null.
  static absl::StatusOr<std::unique_ptr<Coordinator>> Start(const Config& config,
                                                            const Clock& clock = Clock::System(),
                                                            engine::SceneShelf* shelf = nullptr);
  ~Coordinator();  ///< Shutdown with no grace.
  Coordinator(const Coordinator&) = delete;
  Coordinator& operator=(const Coordinator&) = delete;

  /// The port that is listened on; 0 where there is none.
  int port() const;
  /// The port of HTTP; 0 where it is not served.
  int http_port() const;
  /// A channel into this coordinator without a network. Calls through it fail once it has shut down.
  std::shared_ptr<grpc::Channel> InProcessChannel();

  /// Tells workers to drain, ends all streams after at most `grace`, makes everything durable and stops.
  /// Later calls do nothing.
  void Shutdown(absl::Duration grace);

 private:
  class Impl;
  explicit Coordinator(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace shutterline::server
