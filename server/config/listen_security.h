#pragma once

#include <absl/status/status.h>

#include <string>

namespace shutterline::server {

/// How callers prove who they are: names of files, each of which may be empty. With none of them everybody
/// who reaches the coordinator may do everything.
struct ListenSecurity {
  std::string tls_cert, tls_key;  ///< The coordinator's own. Given, everything is encrypted.
  std::string tls_client_ca;      ///< Callers may show certificates of this authority.
  std::string token_file;  ///< Callers may show tokens that this file names (server/auth/token_table.h).

  bool encrypts() const { return !tls_cert.empty(); }
  bool authenticates() const { return !tls_client_ca.empty() || !token_file.empty(); }
};

/// INVALID_ARGUMENT where options do not go together, or would protect less than they seem to: encryption
/// that lets everybody in, or tokens that travel unencrypted. `loopback`: no other machine reaches us.
absl::Status Validate(const ListenSecurity& security, bool loopback);

}  // namespace shutterline::server
