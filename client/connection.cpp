#include "client/connection.h"

#include <absl/strings/str_cat.h>

#include <utility>

#include "common/base/build_id.h"

namespace shutterline::client {
namespace {

constexpr uint32_t kProtocolLow = 1, kProtocolHigh = 1;
constexpr int kMaxReplyBytes = 64 << 20;  // A page of jobs, or a job with all names of its files.

grpc::ChannelArguments NetworkArguments() {
  grpc::ChannelArguments arguments;
  // Streams have no deadline; these find a peer that vanished without a word within 30 s.
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIME_MS, 20'000);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, 10'000);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_PERMIT_WITHOUT_CALLS, 0);
  arguments.SetInt(GRPC_ARG_INITIAL_RECONNECT_BACKOFF_MS, 100);
  arguments.SetInt(GRPC_ARG_MIN_RECONNECT_BACKOFF_MS, 5'000);  // How long an attempt may take.
  arguments.SetInt(GRPC_ARG_MAX_RECONNECT_BACKOFF_MS, 2'000);
  // Repetition is ours: it knows what may be repeated.
  arguments.SetInt(GRPC_ARG_ENABLE_RETRIES, 0);
  arguments.SetMaxReceiveMessageSize(kMaxReplyBytes);
  return arguments;
}

}  // namespace

std::unique_ptr<Connection> Connection::Dial(const std::string& host_port,
                                             const std::shared_ptr<grpc::ChannelCredentials>& credentials,
                                             Options options) {
  return std::make_unique<Connection>(grpc::CreateCustomChannel(host_port, credentials, NetworkArguments()),
                                      absl::StrCat("server ", host_port), std::move(options));
}

Connection::Connection(std::shared_ptr<grpc::Channel> channel, std::string peer, Options options)
    : peer_(std::move(peer)),
      options_(std::move(options)),
      channel_(std::move(channel)),
      jobs_(v1::Jobs::NewStub(channel_)),
      blobs_(v1::Blobs::NewStub(channel_)) {}

bool Connection::PauseAfter(Backoff& backoff, const absl::Status& status) {
  if (backoff.failing()) return backoff.PauseAfter(status);
  if (absl::IsUnavailable(status) && options_.on_wait) {
    options_.on_wait(
        absl::StrCat(peer_, " does not answer, trying again (", std::string(status.message()), ")"));
  }
  return backoff.PauseAfter(status);
}

absl::Status Connection::Explain(const absl::Status& status, absl::string_view what) const {
  if (options_.interrupt != nullptr && options_.interrupt->raised()) {
    return absl::CancelledError(absl::StrCat(what, ": interrupted"));
  }
  switch (status.code()) {
    case absl::StatusCode::kUnavailable:
      return Annotate(status, absl::StrCat(what, ": ", peer_, " does not answer"));
    case absl::StatusCode::kDeadlineExceeded:
      return absl::DeadlineExceededError(absl::StrCat(what, ": ", peer_, " did not answer in time"));
    default:
      return Annotate(status, what);
  }
}

void Connection::SetDeadline(grpc::ClientContext& context, absl::Duration deadline) {
  context.set_deadline(std::chrono::system_clock::now() + absl::ToChronoMilliseconds(deadline));
}

absl::StatusOr<v1::Capabilities> Greet(Connection& connection) {
  SL_ASSIGN_OR_RETURN(
      v1::Capabilities capabilities,
      connection.Repeat<v1::Capabilities>("ask for capabilities", [&](auto* context, auto* reply) {
        return connection.jobs().GetCapabilities(context, v1::CapabilitiesRequest(), reply);
      }));
  const v1::ProtocolRange& theirs = capabilities.protocol();
  if (theirs.high() < kProtocolLow || theirs.low() > kProtocolHigh) {
    return absl::FailedPreconditionError(absl::StrCat(
        connection.peer(), " (", capabilities.build_id(), ") speaks protocol ", theirs.low(), " to ",
        theirs.high(), ", this client (", kBuildId, ") ", kProtocolLow, " to ", kProtocolHigh));
  }
  return capabilities;
}

}  // namespace shutterline::client
