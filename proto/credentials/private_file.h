#pragma once

#include <absl/status/statusor.h>

#include <string>

namespace shutterline::credentials {

/// A file that others must not know or choose.
enum class Secrecy {
  kSecret,  ///< Keys and tokens: others may neither read nor write it, its group may read it.
  kPublic,  ///< Certificates: anybody may read it.
};

/// The content of a regular file of at most 1 MiB. `what` names it in errors ("the key"). PERMISSION_DENIED
/// where the file's mode lets in more than `secrecy` allows (the message says the chmod that helps),
/// INVALID_ARGUMENT where it is empty, too large or no regular file.
absl::StatusOr<std::string> ReadPrivateFile(const std::string& path, absl::string_view what, Secrecy secrecy);

}  // namespace shutterline::credentials
