#pragma once

#include <absl/strings/string_view.h>

#include <string>

namespace shutterline {

/// A random UUID (version 4) from the system's entropy: "0f8fad5b-d9cb-469f-a165-70867728950e".
std::string MakeUuid();

/// Whether `text` has a UUID's form, in lower case: 8-4-4-4-12 hexadecimal digits. Such a text may stand in a
/// file name.
bool IsUuid(absl::string_view text);

}  // namespace shutterline
