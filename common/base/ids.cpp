#include "common/base/ids.h"

#include <absl/strings/escaping.h>
#include <absl/strings/str_cat.h>

#include <random>

namespace shutterline {

std::string MakeUuid() {
  std::random_device entropy;  // The kernel's, on Linux.
  std::string bytes;
  while (bytes.size() < 16) bytes.push_back(char(entropy() & 0xff));
  bytes[6] = char((bytes[6] & 0x0f) | 0x40);  // Version 4: random.
  bytes[8] = char((bytes[8] & 0x3f) | 0x80);  // RFC 4122's variant.
  const std::string hex = absl::BytesToHexString(bytes);
  const absl::string_view h = hex;
  return absl::StrCat(h.substr(0, 8), "-", h.substr(8, 4), "-", h.substr(12, 4), "-", h.substr(16, 4), "-",
                      h.substr(20));
}

bool IsUuid(absl::string_view text) {
  if (text.size() != 36) return false;
  for (size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    const bool dash = i == 8 || i == 13 || i == 18 || i == 23;
    const bool digit = (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f');
    if (dash ? c != '-' : !digit) return false;
  }
  return true;
}

}  // namespace shutterline
