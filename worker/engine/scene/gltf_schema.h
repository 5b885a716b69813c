#pragma once

#include <absl/status/statusor.h>

#include <cstdint>
#include <nlohmann/json_fwd.hpp>

namespace shutterline::engine {

/// A copy of a glTF document that holds what the importer reads and nothing else, every property being
/// of its right type and in its right range: required ones are there, indices name elements that exist,
/// whole numbers are integers that are not negative (1.0 becomes 1, 1e300 is an error), other numbers
/// fit a float and are written as reals, arrays of fixed length have it, and words are among those that glTF
/// knows. What the importer does not read (extras, most extensions, `min` and `max`) is left out unseen.
///
/// Code behind this check, tinygltf above all, may rely on it. INVALID_ARGUMENT names element and
/// property; RESOURCE_EXHAUSTED where one of the document's arrays has more than `max_elements`.
absl::StatusOr<nlohmann::json> ConformToGltfSchema(const nlohmann::json& document, uint32_t max_elements);

}  // namespace shutterline::engine
