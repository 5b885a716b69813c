#pragma once

#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>
#include <absl/time/time.h>
#include <grpcpp/grpcpp.h>

#include <chrono>
#include <functional>
#include <memory>
#include <string>

#include "client/interrupt.h"
#include "client/retry.h"
#include "common/base/status_macros.h"
#include "proto/convert/status.h"
#include "shutterline/v1/blobs.grpc.pb.h"
#include "shutterline/v1/jobs.grpc.pb.h"

namespace shutterline::client {

inline constexpr absl::Duration kUnaryDeadline = absl::Seconds(10);
/// A coordinator imports the scene before it answers, for 2 minutes (--scene-seconds) at the most.
inline constexpr absl::Duration kSubmitDeadline = absl::Minutes(3);

/// A coordinator as the commands see it: stubs, deadlines, repetition and words for errors. Thread-safe.
class Connection {
 public:
  struct Options {
    RetryPolicy retry;
    /// How long a watch survives a coordinator that is away: enough for a restart of its machine.
    absl::Duration watch_patience = absl::Minutes(10);
    Interrupt* interrupt = nullptr;  ///< Cancels calls that are under way. May be null.
    /// Told once per call, when it is going to be repeated: "HOST:PORT does not answer (...)".
    std::function<void(absl::string_view)> on_wait;
  };

  /// To a coordinator over the network, as secure as `credentials` are. Nothing is dialled before the first
  /// call.
  static std::unique_ptr<Connection> Dial(const std::string& host_port,
                                          const std::shared_ptr<grpc::ChannelCredentials>& credentials,
                                          Options options);
  /// Over a channel that exists; `peer` names it in messages.
  Connection(std::shared_ptr<grpc::Channel> channel, std::string peer, Options options);

  v1::Jobs::StubInterface& jobs() { return *jobs_; }
  v1::Blobs::StubInterface& blobs() { return *blobs_; }
  const std::string& peer() const { return peer_; }
  const Options& options() const { return options_; }

  /// A unary call that may be repeated: `call(context, reply)` is tried until it is not UNAVAILABLE or
  /// patience ends. `what` says what is being done ("submit the job"). Each try has `deadline`.
  template <typename Reply, typename Call>
  absl::StatusOr<Reply> Repeat(absl::string_view what, Call call, absl::Duration deadline = kUnaryDeadline) {
    Backoff backoff(options_.retry, options_.interrupt);
    while (true) {
      grpc::ClientContext context;
      SetDeadline(context, deadline);
      Interrupt::Guard guard(options_.interrupt, [&context] { context.TryCancel(); });
      Reply reply;
      const absl::Status status = convert::FromGrpc(call(&context, &reply));
      if (status.ok()) return reply;
      if (!PauseAfter(backoff, status)) return Explain(status, what);
    }
  }

  /// Backoff::PauseAfter, telling the user that we wait.
  bool PauseAfter(Backoff& backoff, const absl::Status& status);
  /// `status` for people: what was being done and with whom; CANCELLED by the user is said as such.
  absl::Status Explain(const absl::Status& status, absl::string_view what) const;

  static void SetDeadline(grpc::ClientContext& context, absl::Duration deadline);

 private:
  const std::string peer_;
  const Options options_;
  const std::shared_ptr<grpc::Channel> channel_;
  const std::unique_ptr<v1::Jobs::StubInterface> jobs_;
  const std::unique_ptr<v1::Blobs::StubInterface> blobs_;
};

/// Compares protocol ranges: FAILED_PRECONDITION naming both sides where they do not meet. Returns the
/// coordinator's limits.
absl::StatusOr<v1::Capabilities> Greet(Connection& connection);

}  // namespace shutterline::client
