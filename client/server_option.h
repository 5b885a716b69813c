#pragma once

#include <absl/status/status.h>
#include <absl/strings/string_view.h>

#include <memory>
#include <string>

#include "client/command_line.h"
#include "client/connection.h"
#include "common/base/dial_security.h"

namespace shutterline::client {

/// --server HOST:PORT, or the environment variable SHUTTERLINE_SERVER, and how to speak to it: --tls-ca,
/// --tls-cert, --tls-key and --token-file, or SHUTTERLINE_TLS_CA and so on.
class ServerOption {
 public:
  void Declare(CLI::App& app);
  /// INVALID_ARGUMENT where no coordinator was named.
  absl::Status Check() const;
  /// Reads certificates and tokens, dials and compares protocols. Waits are told to `console`, unless
  /// `quiet`.
  absl::StatusOr<std::unique_ptr<Connection>> Connect(Console& console, Interrupt* interrupt,
                                                      bool quiet = false) const;

  const std::string& host_port() const { return host_port_; }

 private:
  std::string host_port_;
  DialSecurity security_;
};

/// OK for "HOST:PORT" with a port from 1 to 65535; the host is a name, an IPv4 address or an IPv6 address
/// in brackets. INVALID_ARGUMENT saying what is allowed otherwise.
absl::Status CheckHostPort(absl::string_view text);

}  // namespace shutterline::client
