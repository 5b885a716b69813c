#include "server/config/listen_security.h"

namespace shutterline::server {

absl::Status Validate(const ListenSecurity& s, bool loopback) {
  if (s.tls_cert.empty() != s.tls_key.empty()) {
    return absl::InvalidArgumentError("tls_cert and tls_key go together");
  }
  if (!s.tls_client_ca.empty() && !s.encrypts()) {
    return absl::InvalidArgumentError("tls_client_ca needs tls_cert and tls_key");
  }
  if (s.encrypts() && !s.authenticates()) {
    return absl::InvalidArgumentError(
        "tls_cert alone would encrypt, but let everybody in; add tls_client_ca or token_file");
  }
  if (!s.token_file.empty() && !s.encrypts() && !loopback) {
    return absl::InvalidArgumentError(
        "token_file needs tls_cert and tls_key, unless the coordinator listens on 127.0.0.1: tokens would "
        "travel "
        "unencrypted");
  }
  return absl::OkStatus();
}

}  // namespace shutterline::server
