#include "worker/engine/scene/gltf_uri.h"

#include <absl/status/status.h>
#include <absl/strings/ascii.h>
#include <absl/strings/escaping.h>
#include <absl/strings/match.h>
#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>
#include <absl/strings/str_split.h>

#include <vector>

#include "common/base/status_macros.h"

namespace shutterline::engine {
namespace {

/// A URI for a message: cut, escaped.
std::string Shown(absl::string_view uri) {
  return absl::StrCat("\"", absl::CEscape(uri.substr(0, 80)), uri.size() > 80 ? "...\"" : "\"");
}

absl::StatusOr<std::string> PercentDecode(absl::string_view text) {
  std::string result;
  result.reserve(text.size());
  for (size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '%') {
      result.push_back(text[i]);
      continue;
    }
    if (i + 2 >= text.size() || !absl::ascii_isxdigit(text[i + 1]) || !absl::ascii_isxdigit(text[i + 2])) {
      return absl::InvalidArgumentError(absl::StrCat("uri ", Shown(text), ": '%' without two hex digits"));
    }
    result += absl::HexStringToBytes(text.substr(i + 1, 2));
    i += 2;
  }
  return result;
}

bool HasScheme(absl::string_view path) {
  if (path.empty() || !absl::ascii_isalpha(path[0])) return false;
  for (const char c : path) {
    if (c == ':') return true;
    if (!absl::ascii_isalnum(c) && c != '+' && c != '-' && c != '.') return false;
  }
  return false;
}

}  // namespace

bool IsDataUri(absl::string_view uri) {
  return absl::StartsWithIgnoreCase(uri, "data:");
}

absl::StatusOr<std::string> DecodeDataUri(absl::string_view uri, uint64_t max_bytes) {
  const size_t comma = uri.find(',');
  if (!IsDataUri(uri) || comma == absl::string_view::npos) {
    return absl::InvalidArgumentError(absl::StrCat("data URI ", Shown(uri), ": no comma before the data"));
  }
  const bool base64 = absl::EndsWithIgnoreCase(uri.substr(0, comma), ";base64");
  const absl::string_view data = uri.substr(comma + 1);
  // Three bytes at most of four characters, one of one where they are escapes or plain.
  if ((base64 ? data.size() / 4 * 3 : data.size() / 3) > max_bytes) {
    return absl::ResourceExhaustedError(
        absl::StrCat("data URI of ", data.size(), " characters exceeds the limit of ", max_bytes, " bytes"));
  }
  if (!base64) return PercentDecode(data);
  std::string result;
  if (!absl::Base64Unescape(data, &result)) {
    return absl::InvalidArgumentError(absl::StrCat("data URI ", Shown(uri), ": it is not base64"));
  }
  return result;
}

absl::StatusOr<std::string> DecodeFileUri(absl::string_view uri) {
  SL_ASSIGN_OR_RETURN(const std::string path, PercentDecode(uri));
  return NormalizeRelativePath(path);
}

absl::StatusOr<std::string> NormalizeRelativePath(absl::string_view path) {
  const auto refuse = [&](absl::string_view reason) {
    return absl::InvalidArgumentError(absl::StrCat("uri ", Shown(path), ": ", reason));
  };
  if (path.empty()) return refuse("it is empty");
  if (path[0] == '/') return refuse("it is absolute; only files beside the scene are read");
  if (HasScheme(path)) return refuse("it has a scheme; only files beside the scene are read");
  for (const char c : path) {
    if (absl::ascii_iscntrl(c) || c == '\\') return refuse("it has a control character or a backslash");
  }
  std::vector<absl::string_view> parts;
  for (absl::string_view part : absl::StrSplit(path, '/')) {
    if (part.empty() || part == ".") continue;
    if (part == "..") {
      if (parts.empty()) return refuse("it leaves the scene's folder");
      parts.pop_back();
    } else {
      parts.push_back(part);
    }
  }
  if (parts.empty()) return refuse("it names no file");
  return absl::StrJoin(parts, "/");
}

}  // namespace shutterline::engine
