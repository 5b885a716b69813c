#pragma once

#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>

#include <string>

/// Bearer tokens: secrets that travel in a call's `authorization` header, as "Bearer TOKEN".
namespace shutterline::credentials {

inline constexpr size_t kMinTokenBytes = 32;  ///< In hexadecimal digits still 128 bits.
inline constexpr size_t kMaxTokenBytes = 512;

/// INVALID_ARGUMENT unless `token` has the length above and consists of letters, digits and -._~+/= alone
/// (RFC 6750). The message does not repeat it.
absl::Status CheckToken(absl::string_view token);

/// The token in a file: its one line. The file must be readable by its owner (and group) alone.
absl::StatusOr<std::string> LoadToken(const std::string& file);

}  // namespace shutterline::credentials
