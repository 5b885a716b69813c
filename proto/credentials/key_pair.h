#pragma once

#include <absl/status/statusor.h>

#include <string>

namespace shutterline::credentials {

/// Who we are: a certificate (with the chain that follows it in its file) and its private key, both PEM.
struct KeyPair {
  std::string certificate, key;
};

/// Reads both files. Errors name the file: where it is no PEM, the key is not the certificate's, the
/// certificate is not valid yet or any more, or others may read the key.
absl::StatusOr<KeyPair> LoadKeyPair(const std::string& certificate_file, const std::string& key_file);

/// Whom we trust: one or several certificates of authorities, PEM. Errors as for LoadKeyPair.
absl::StatusOr<std::string> LoadAuthorities(const std::string& file);

}  // namespace shutterline::credentials
