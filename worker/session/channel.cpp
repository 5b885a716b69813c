#include "worker/session/channel.h"

#include <grpcpp/grpcpp.h>

#include "common/base/status_macros.h"
#include "proto/credentials/channel_credentials.h"

namespace shutterline::worker {

absl::StatusOr<std::shared_ptr<grpc::Channel>> DialCoordinator(const std::string& host_port,
                                                               const DialSecurity& security) {
  SL_ASSIGN_OR_RETURN(const auto credentials, credentials::MakeChannelCredentials(security, host_port));
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIME_MS, 20'000);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, 10'000);
  // How often to try is the session's decision (Backoff): the channel must not refuse without dialling.
  arguments.SetInt(GRPC_ARG_INITIAL_RECONNECT_BACKOFF_MS, 50);
  // How long an attempt may take, in spite of its name. Two round trips at least, and a second more for
  // every lost packet: with less, a worker far away never gets through.
  arguments.SetInt(GRPC_ARG_MIN_RECONNECT_BACKOFF_MS, 5'000);
  arguments.SetInt(GRPC_ARG_MAX_RECONNECT_BACKOFF_MS, 1'000);
  // A job's description names its files: the protocol allows 10,000 of up to 1 KiB.
  arguments.SetMaxReceiveMessageSize(64 << 20);
  return grpc::CreateCustomChannel(host_port, credentials, arguments);
}

}  // namespace shutterline::worker
