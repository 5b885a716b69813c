#pragma once

#include <absl/status/statusor.h>
#include <grpcpp/security/credentials.h>

#include <memory>
#include <string>

namespace shutterline::credentials {

/// How a client or a worker speaks to a coordinator: names of files, each of which may be empty.
struct DialSecurity {
  std::string tls_ca;             ///< Whom to trust; given, everything is encrypted.
  std::string tls_cert, tls_key;  ///< Who we are. Both or none, and with `tls_ca` alone.
  std::string token_file;         ///< Or so. Without `tls_ca` only to a loopback address.
};

/// The credentials for a channel to `host_port`. INVALID_ARGUMENT where the options do not go together;
/// otherwise what is wrong with a file. A token never leaves the machine unencrypted: FAILED_PRECONDITION
/// where `host_port` names another machine, and should a name that looks local lead elsewhere after all, the
/// connection is refused before anything is sent.
absl::StatusOr<std::shared_ptr<grpc::ChannelCredentials>> MakeChannelCredentials(
    const DialSecurity& security, const std::string& host_port);

}  // namespace shutterline::credentials
