#pragma once

#include <absl/status/statusor.h>
#include <grpcpp/security/server_credentials.h>

#include <memory>

#include "server/auth/authorizer.h"
#include "server/config/listen_security.h"

namespace shutterline::server {

/// The credentials of a listening port. With none of the files of `security` everybody is let in; otherwise
/// every call passes `authorizer`. With TLS callers are asked for a certificate and may go without, but one
/// that they show must be of our authority: otherwise probes could not ask for our health, and who forgot his
/// certificate would get no answer but a broken connection. With tokens alone, connections that leave the
/// machine are refused. Errors name the file that is wrong.
absl::StatusOr<std::shared_ptr<grpc::ServerCredentials>> MakeServerCredentials(
    const ListenSecurity& security, std::shared_ptr<const Authorizer> authorizer);

}  // namespace shutterline::server
