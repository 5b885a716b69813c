#pragma once

#include <absl/strings/string_view.h>
#include <absl/time/time.h>

#include <cstdint>
#include <string>

namespace shutterline::client {

/// "0 bytes", "1 byte", "999 bytes", "1.5 kB", "12 MB": decimal units, about three digits.
std::string HumanBytes(uint64_t bytes);
/// "43s", "2m07s", "1h05m": whole seconds, never negative.
std::string ShortDuration(absl::Duration duration);
/// `text` for a terminal: control characters, which could move the cursor or forge a line, become '?'.
std::string Printable(absl::string_view text);

}  // namespace shutterline::client
