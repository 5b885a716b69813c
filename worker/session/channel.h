#pragma once

#include <absl/status/statusor.h>

#include <memory>
#include <string>

#include "common/base/dial_security.h"

namespace grpc {
class Channel;
}  // namespace grpc

namespace shutterline::worker {

/// A channel to a coordinator's "HOST:PORT", as secure as `security` says. Dials when it is first used and
/// again when it has to; notices a dead peer within 30 s. Errors as of credentials::MakeChannelCredentials.
absl::StatusOr<std::shared_ptr<grpc::Channel>> DialCoordinator(const std::string& host_port,
                                                               const DialSecurity& security);

}  // namespace shutterline::worker
