#include "common/base/utf8.h"

#include <cstdint>

namespace shutterline {
namespace {

bool IsContinuation(char c) {
  return (uint8_t(c) & 0xC0) == 0x80;
}

/// Bytes of the character that `text` begins with; 0 where it begins with none. Table 3-7 of the Unicode
/// standard.
size_t CharacterBytes(absl::string_view text) {
  const auto lead = uint8_t(text[0]);
  if (lead < 0x80) return 1;
  const size_t size = lead >= 0xF0 ? 4 : lead >= 0xE0 ? 3 : 2;
  if (lead < 0xC2 || lead > 0xF4 || text.size() < size) return 0;
  for (size_t i = 1; i < size; ++i) {
    if (!IsContinuation(text[i])) return 0;
  }
  const auto second = uint8_t(text[1]);
  if ((lead == 0xE0 && second < 0xA0) || (lead == 0xF0 && second < 0x90)) return 0;  // Overlong.
  if ((lead == 0xED && second > 0x9F) || (lead == 0xF4 && second > 0x8F)) return 0;  // Surrogates, too large.
  return size;
}

}  // namespace

absl::string_view Utf8Prefix(absl::string_view text, size_t max_bytes) {
  if (text.size() <= max_bytes) return text;
  size_t end = max_bytes;
  while (end > 0 && IsContinuation(text[end])) --end;
  return text.substr(0, end);
}

std::string ValidUtf8(absl::string_view text) {
  std::string valid;
  valid.reserve(text.size());
  while (!text.empty()) {
    const size_t size = CharacterBytes(text);
    if (size == 0) {
      valid += '?';
    } else {
      valid.append(text.data(), size);
    }
    text.remove_prefix(size == 0 ? 1 : size);
  }
  return valid;
}

std::string WithoutControls(std::string text) {
  for (size_t i = 0; i < text.size(); ++i) {
    const auto byte = uint8_t(text[i]);
    if ((byte < 0x20 && byte != '\n') || byte == 0x7f) text[i] = '?';
    // C1, in two bytes. No other character has this first byte and so small a second one.
    if (byte == 0xc2 && i + 1 < text.size() && uint8_t(text[i + 1]) < 0xa0) text[i] = text[i + 1] = '?';
  }
  return text;
}

}  // namespace shutterline
