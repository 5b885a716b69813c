#pragma once

#include <string>

namespace shutterline {

/// How a client or a worker speaks to a coordinator: names of files, each of which may be empty.
struct DialSecurity {
  std::string tls_ca;             ///< Whom to trust; given, everything is encrypted.
  std::string tls_cert, tls_key;  ///< Who we are. Both or none, and with `tls_ca` alone.
  std::string token_file;         ///< Or so. Without `tls_ca` only to a loopback address.
};

}  // namespace shutterline
