#include "worker/engine/scene/gltf_json.h"

#include <absl/status/status.h>
#include <absl/strings/str_cat.h>

#include <algorithm>
#include <new>
#include <nlohmann/json.hpp>

namespace shutterline::engine {
namespace {

struct Extent {
  uint32_t depth = 0;   ///< The deepest nesting: whatever walks the parsed tree by recursion may rely on it.
  uint64_t values = 1;  ///< No fewer than there are.
};

/// Read off the brackets and commas outside of strings.
Extent ExtentOf(absl::string_view text) {
  Extent extent;
  uint32_t depth = 0;
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
      extent.depth = std::max(extent.depth, ++depth);
      ++extent.values;
    } else if ((c == ']' || c == '}') && depth > 0) {
      --depth;
    } else if (c == ',') {
      ++extent.values;
    }
  }
  return extent;
}

}  // namespace

absl::StatusOr<nlohmann::json> ParseBoundedJson(absl::string_view text, uint32_t max_depth,
                                                uint64_t max_values) {
  const Extent extent = ExtentOf(text);
  if (extent.depth > max_depth) {
    return absl::ResourceExhaustedError(
        absl::StrCat("JSON: nested ", extent.depth, " deep, more than the limit of ", max_depth));
  }
  if (extent.values > max_values) {
    return absl::ResourceExhaustedError(
        absl::StrCat("JSON: ", extent.values, " values, more than the limit of ", max_values));
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
