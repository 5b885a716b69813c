#include "worker/engine/scene/gltf_json.h"

#include <absl/status/status.h>
#include <absl/strings/str_cat.h>

#include <new>
#include <nlohmann/json.hpp>

namespace shutterline::engine {
namespace {

/// The deepest nesting, read off the brackets outside of strings. Whatever walks the parsed tree by
/// recursion may then rely on it.
uint32_t NestingDepth(absl::string_view text) {
  uint32_t depth = 0, deepest = 0;
  bool in_string = false;
  for (size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_string) {
      if (c == '\\') {
        ++i;
      } else if (c == '"') {
        in_string = false;
      }
    } else if (c == '"') {
      in_string = true;
    } else if (c == '[' || c == '{') {
      deepest = std::max(deepest, ++depth);
    } else if ((c == ']' || c == '}') && depth > 0) {
      --depth;
    }
  }
  return deepest;
}

}  // namespace

absl::StatusOr<nlohmann::json> ParseBoundedJson(absl::string_view text, uint32_t max_depth) {
  if (const uint32_t depth = NestingDepth(text); depth > max_depth) {
    return absl::ResourceExhaustedError(
        absl::StrCat("JSON: nested ", depth, " deep, more than the limit of ", max_depth));
  }
  try {
    return nlohmann::json::parse(text.data(), text.data() + text.size());
  } catch (const std::bad_alloc&) {
    return absl::ResourceExhaustedError("JSON: out of memory");
  } catch (const nlohmann::json::exception& error) {
    return absl::InvalidArgumentError(absl::StrCat("JSON: ", error.what()));
  }
}

}  // namespace shutterline::engine
