#pragma once

#include <absl/status/statusor.h>
#include <grpcpp/security/credentials.h>

#include <memory>
#include <string>

#include "common/base/dial_security.h"

namespace shutterline::credentials {

/// The credentials for a channel to `host_port`. INVALID_ARGUMENT where the options do not go together;
/// otherwise what is wrong with a file. A token never leaves the machine unencrypted: FAILED_PRECONDITION
/// where `host_port` names another machine, and should a name that looks local lead elsewhere after all, the
/// connection is refused before anything is sent.
absl::StatusOr<std::shared_ptr<grpc::ChannelCredentials>> MakeChannelCredentials(
    const DialSecurity& security, const std::string& host_port);

}  // namespace shutterline::credentials
