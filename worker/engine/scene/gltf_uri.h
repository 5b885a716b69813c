#pragma once

#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>

#include <cstdint>
#include <string>

namespace shutterline::engine {

/// Whether a URI as it stands in a file is a data URI ("data:...").
bool IsDataUri(absl::string_view uri);

/// The bytes of a data URI, base64 or percent-encoded. RESOURCE_EXHAUSTED where they are more than
/// `max_bytes`, checked before they are decoded.
absl::StatusOr<std::string> DecodeDataUri(absl::string_view uri, uint64_t max_bytes);

/// A file's relative URI with its percent escapes decoded and its path normalised (see below).
absl::StatusOr<std::string> DecodeFileUri(absl::string_view uri);

/// A decoded relative path in its shortest form: "a/./b/../c.bin" is "a/c.bin". INVALID_ARGUMENT where
/// it is empty, absolute, has a scheme ("http:"), a control character or a backslash, or where ".."
/// leaves the folder.
absl::StatusOr<std::string> NormalizeRelativePath(absl::string_view path);

}  // namespace shutterline::engine
