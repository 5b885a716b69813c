#pragma once

#include <absl/status/statusor.h>
#include <absl/strings/string_view.h>

#include <cstdint>
#include <nlohmann/json_fwd.hpp>

namespace shutterline::engine {

/// Parses JSON of at most `max_values` values whose arrays and objects nest at most `max_depth` deep, both
/// counted before memory is taken; no exception leaves. Where a key
/// occurs twice in an object, the last one counts.
absl::StatusOr<nlohmann::json> ParseBoundedJson(absl::string_view text, uint32_t max_depth,
                                                uint64_t max_values);

}  // namespace shutterline::engine
