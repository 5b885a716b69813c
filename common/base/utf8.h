#pragma once

#include <absl/strings/string_view.h>

#include <string>

/// Messages carry text as UTF-8 alone: one that holds anything else cannot be parsed by whoever gets it.
namespace shutterline {

/// The longest beginning of `text` that has at most `max_bytes` and ends between two characters.
absl::string_view Utf8Prefix(absl::string_view text, size_t max_bytes);

/// `text` with a '?' for every byte that is no part of a character: cut ones, overlong ones, surrogates.
std::string ValidUtf8(absl::string_view text);

/// `text`, which is UTF-8, with a '?' for every byte of a control character (C0, DEL, C1) but line feeds:
/// none of it steers a terminal.
std::string WithoutControls(std::string text);

}  // namespace shutterline
